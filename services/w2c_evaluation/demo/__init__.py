"""The demo: scenario (a) of the paper from the first word to the reached cup, and other scenes."""
