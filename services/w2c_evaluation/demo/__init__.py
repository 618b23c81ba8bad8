"""Scenario (a) of the paper, from the first word to the reached cup."""
