"""Starts the processes of a profile, waits until ready, watches, restarts, stops in order."""
