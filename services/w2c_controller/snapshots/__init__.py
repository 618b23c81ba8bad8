"""All of a controller's state, to go on from after its own death."""
