"""Perception: what is behind a pixel of a past picture, in the world, with an honest error."""
