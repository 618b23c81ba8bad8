"""Grounding: a picture and phrases in, heatmaps, boxes and points out. Knows nothing of robots."""
