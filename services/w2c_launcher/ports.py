"""Ports: free ones for private systems, a clear word about busy ones."""

import socket

from w2c.errors import ConfigError


def free_port() -> int:
    """Return a TCP port of the loopback interface that was free a moment ago."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def require_free(endpoint: str, flag: str) -> None:
    """Raise ConfigError if something listens at a `tcp/HOST:PORT` endpoint."""
    if not endpoint.startswith("tcp/"):
        return
    host, _, port = endpoint.removeprefix("tcp/").rpartition(":")
    if not port.isdigit():
        raise ConfigError(f"{flag} {endpoint}: expected tcp/HOST:PORT")
    with socket.socket() as probe:
        probe.settimeout(0.5)
        if probe.connect_ex((host, int(port))) == 0:
            raise ConfigError(f"port {port} is in use by another program; choose another {flag}")
