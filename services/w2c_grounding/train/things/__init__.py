"""Trains the network of things on pictures, and on which pixels belong to which thing."""
