"""Which gains of the force feedback: pushes and leaning reaches with a robot unlike its model."""
