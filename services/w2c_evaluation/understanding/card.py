"""Scores into the card of the model that was judged."""

import re
from pathlib import Path

from w2c.errors import ConfigError

_PLACE = re.compile(r"(<!-- scores -->\n).*?(\n<!-- end -->)", re.DOTALL)


def fill_card(path: Path, tables: str) -> None:
    """Put tables in the place that the training left for them, or that of older ones.

    Raises:
        ConfigError: the card cannot be read or written, or has no such place.
    """
    try:
        text = path.read_text(encoding="utf-8")
        filled, count = _PLACE.subn(lambda match: match[1] + tables.strip() + match[2], text)
        if count != 1:
            raise ConfigError(
                f"{path} has {count} places for scores; a card has one, from <!-- scores --> to "
                "<!-- end -->"
            )
        path.write_text(filled, encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"the card {path} cannot be filled: {error}") from error
