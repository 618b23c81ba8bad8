"""Scenes: what stands in front of the simulated robot, built from primitives and procedural textures."""
