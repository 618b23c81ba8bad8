"""Where the things of a picture are, whatever they are called: one look for all phrases."""
