"""Trains outlines on what a model lights in pictures, and on where those things end."""
