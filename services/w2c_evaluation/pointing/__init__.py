"""How often the arg-max of a heatmap lies on what was named, on scenes that no training saw."""
