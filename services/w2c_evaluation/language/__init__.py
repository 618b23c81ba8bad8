"""What a question to a language model costs."""
