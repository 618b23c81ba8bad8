"""A thing's outline, drawn from near: where does what was found end?

The heat of a family covers a bottle's neck and not its body, or a screwdriver's handle alone. Where
that thing ends is plain in the picture, whatever it is called.
"""
