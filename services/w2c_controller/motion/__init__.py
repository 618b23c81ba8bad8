"""How end effectors and head move: targets, filters, paths, and what they must clear."""
