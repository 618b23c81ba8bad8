"""What is recorded, once more in the messages that Foxglove and Rerun show."""
