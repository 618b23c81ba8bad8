"""The head camera of the simulated robot, rendered in a process of its own so that physics stays punctual."""
