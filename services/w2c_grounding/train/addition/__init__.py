"""What trainings that add a network to a checkpoint have in common: flags, course, end."""
