"""What answers of a vision model cost."""
