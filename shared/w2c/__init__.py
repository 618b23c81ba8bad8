"""The contract between the processes: messages, topics, bus, geometry, life cycle."""

__version__ = "0.1.0"
