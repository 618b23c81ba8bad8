"""How far, how fast and with how much unknown mass a robot may reach before it falls."""
