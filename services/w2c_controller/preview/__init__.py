"""What would come of a goal, searched in a process of its own."""
