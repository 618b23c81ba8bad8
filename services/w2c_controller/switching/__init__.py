"""How contacts are made, watched and left: the phases of a goal."""
