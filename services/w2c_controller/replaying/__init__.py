"""A controller of its own, run on recorded states: does it give the recorded commands?"""
