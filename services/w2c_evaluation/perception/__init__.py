"""How far off a lifted pixel is, against the simulator's truth."""
