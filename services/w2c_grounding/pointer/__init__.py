"""Vision-language models that answer with coordinates, behind a server or in this process."""
