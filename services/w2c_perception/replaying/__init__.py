"""Perception on recorded pictures and states: are the points where they were?"""
