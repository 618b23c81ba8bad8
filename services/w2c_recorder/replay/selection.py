"""Which keys of a recording are played."""

from collections.abc import Iterable
from fnmatch import fnmatchcase

from w2c import topics
from w2c_recorder.liveliness import is_liveliness_key
from w2c_recorder.replay.options import ReplayOptions

COMMANDS = ("cmd", "goal")
"""Kinds that make something move"""


def name_of(key: str) -> str:
    """Return KIND/SERVICE/NAME of a key; "" for one of another form or version."""
    parts = key.split("/")
    if len(parts) != 6 or parts[:2] != ["w2c", topics.VERSION]:
        return ""
    return "/".join(parts[3:])


class Selection:
    """Tells which keys are played. Liveliness is no message, it is stood in for."""

    def __init__(self, options: ReplayOptions) -> None:
        self._options = options
        self._decided: dict[str, bool] = {}

    @property
    def seen(self) -> list[str]:
        """KIND/SERVICE/NAME of all keys that were asked for, played or not."""
        return sorted({name_of(key) for key in self._decided if not is_liveliness_key(key)} - {""})

    def __call__(self, key: str) -> bool:
        """Tell whether the messages of a key are played."""
        decided = self._decided.get(key)
        if decided is None:
            decided = not is_liveliness_key(key) and self._has(name_of(key))
            self._decided[key] = decided
        return decided

    def shows(self, service: str) -> bool:
        """Tell whether a process is stood in for: where its health reports are played."""
        return self._has(name_of(topics.HEALTH.key("", service)))

    def _has(self, name: str) -> bool:
        options = self._options
        if not name or (name.split("/", maxsplit=1)[0] in COMMANDS and not options.with_commands):
            return False
        return _fits(name, options.include) and not _fits(name, options.exclude)


def _fits(name: str, patterns: Iterable[str]) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns)
