"""What a request costs here, beside llama-cpp-python's own way to ask it."""
