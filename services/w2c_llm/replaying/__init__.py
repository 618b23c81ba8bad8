"""A language model asked again what it was asked in a recording."""
