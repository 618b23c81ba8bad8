"""What `w2c bench recording` measures."""
