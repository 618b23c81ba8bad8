"""Configuration of the console."""

import ipaddress
from typing import Annotated

import msgspec

from w2c.config import ServiceConfig
from w2c.errors import ConfigError


class ConsoleConfig(ServiceConfig, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the page is served, and to whom."""

    host: str = "127.0.0.1"
    """Address to listen at. Whoever can open the page can move the robot."""
    port: Annotated[int, msgspec.Meta(ge=0, le=65535)] = 8080
    """Port to listen at; 0 = any free one, printed in the log."""
    allow_remote: bool = False
    """Serve other machines than this one. The page has no password: use a proxy that has one."""
    title: Annotated[str, msgspec.Meta(min_length=1, max_length=80)] = "Words2Contact"
    """Heading of the page."""


def check_exposure(config: ConsoleConfig) -> None:
    """Raise ConfigError for an address that others can reach, unless that was asked for."""
    if not config.allow_remote and not is_loopback(config.host):
        raise ConfigError(
            f"--host {config.host} is open to other machines, and the page has no password; "
            "use --host 127.0.0.1, or add --allow-remote if that is meant"
        )


def is_loopback(host: str) -> bool:
    """Tell whether an address is this machine's own."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:  # a name: it may resolve to anything
        return False
