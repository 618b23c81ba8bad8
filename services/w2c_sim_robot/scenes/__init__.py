"""Scenes: what stands in front of the simulated robot, all of it made by procedures."""
