"""A look at each region that a phrase lights, as close as the picture allows: is it what was said?

A heatmap's model reads the whole picture in patches; a thing is a few of them, and whether it is
made of wood or of plastic is lost in them. Here every region is cut out and looked at by a small
network of its own.
"""
