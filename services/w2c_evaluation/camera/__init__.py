"""What pictures of the simulated camera cost."""
