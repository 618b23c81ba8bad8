"""Which processes came and went, as messages: the bus knows it, but nobody publishes it."""

from collections.abc import Iterable
from typing import Annotated

import msgspec

from w2c.messages import Message
from w2c.topics import liveliness_key

Identity = tuple[str, str]
"""Service and instance."""


class Liveliness(Message, frozen=True, kw_only=True):
    """A process appeared on the bus, or disappeared from it."""

    service: Annotated[str, msgspec.Meta(max_length=100)]
    instance: Annotated[str, msgspec.Meta(max_length=100)]
    alive: bool


class LivelinessWatch:
    """Turns the list of live processes into changes. Pure."""

    def __init__(self) -> None:
        self._known: set[Identity] = set()

    def changes(self, alive: Iterable[Identity]) -> list[Liveliness]:
        """Return what changed since the last call, departures first, each sorted by name."""
        now = set(alive)
        gone, new = sorted(self._known - now), sorted(now - self._known)
        self._known = now
        return [
            Liveliness(service=service, instance=instance, alive=is_alive)
            for identities, is_alive in ((gone, False), (new, True))
            for service, instance in identities
        ]


def key_of(robot: str, change: Liveliness) -> str:
    """Return the key under which a change is recorded: that of the token itself."""
    return liveliness_key(robot, change.service, change.instance)


def is_liveliness_key(key: str) -> bool:
    """Tell whether a recorded key is that of a liveliness token."""
    parts = key.split("/")
    return len(parts) == 6 and parts[3] == "live"
