"""Ports that nobody uses."""

import socket


def free_port() -> int:
    """Return a TCP port that was free a moment ago."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def free_endpoint() -> str:
    """Return a Zenoh endpoint on the loopback interface."""
    return f"tcp/127.0.0.1:{free_port()}"
