"""What to ask a pointing model, and how to read its answers."""

from typing import Annotated, Literal

import msgspec

Units = Literal["auto", "unit", "hundred", "thousand", "pixels"]
"""What the far edges of the picture are called: 1, 100, 1000, or their number of pixels in the
picture as the model got it. auto: 1 where no number of the answer is larger, else 1000."""

Format = Literal["auto", "molmo", "locations", "tagged", "json", "tuples"]
"""See `formats`."""


class PointerOptions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Of the family `pointer`; a model's name does not tell any of it."""

    url: str = ""
    """Base address of an OpenAI-compatible server, as in http://127.0.0.1:8080/v1; then the model
    is a name at the server. Empty: a checkpoint in this process."""
    key_file: str = ""
    """File with the server's key; empty: the environment variable OPENAI_API_KEY; else none."""
    ask_for: Literal["points", "boxes"] = "points"
    """What the model is asked to answer with; a phrase template with words in it replaces the
    question."""
    format: Format = "auto"
    """Of the answer; auto: the first that finds a place."""
    units: Units = "auto"
    """What the far edges of the picture are called where the format does not say: 1, 100, 1000 or
    pixels; auto: 1 or 1000, by the numbers."""
    reach: Annotated[float, msgspec.Meta(gt=0.0, le=0.5)] = 0.015
    """Radius of the region around a point, as a share of the picture's width."""
    longest_side: Annotated[int, msgspec.Meta(ge=64, le=8192)] = 1280
    """The picture is shrunk to this before it is sent [px]."""
    max_tokens: Annotated[int, msgspec.Meta(gt=0, le=4096)] = 400
    """Longest answer."""
    deadline: Annotated[float, msgspec.Meta(gt=0, le=600)] = 50.0
    """Longest time of one question to the server [s]; callers wait 60 s for all their phrases."""
    concurrency: Annotated[int, msgspec.Meta(ge=1, le=64)] = 4
    """Phrases at the server at once."""
    sampling: bool = True
    """Send temperature 0; off for models that refuse it."""
    token_limit: Literal["max_tokens", "max_completion_tokens"] = "max_tokens"  # noqa: S105
    """Name of the limit in the server's interface."""
