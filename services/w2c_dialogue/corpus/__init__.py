"""What the embedded language model learns from: how people tell a robot where to put its hands."""
