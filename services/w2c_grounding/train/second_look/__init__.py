"""Trains the second look on the things of pictures, cut out where the truth has them."""
