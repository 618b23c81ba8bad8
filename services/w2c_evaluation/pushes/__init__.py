"""How exactly a hand pushes, and whether the robot stands what it was not told."""
