"""The head camera of the simulated robot: a process of its own, so that physics is punctual."""
