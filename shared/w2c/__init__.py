"""The contract between the processes of Words2Contact: messages, topics, bus, geometry, life cycle."""

__version__ = "0.1.0"
