"""What must not be, what is done about it, and how the controller begins and stops."""
