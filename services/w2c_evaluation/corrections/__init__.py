"""The pilot study of the paper with scripted operators (`w2c evaluate corrections`)."""
