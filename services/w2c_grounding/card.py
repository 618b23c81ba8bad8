"""`grounding.json` beside the weights of a checkpoint: how it was trained to be asked.

A checkpoint directory of this project carries the phrase template, the calibrated threshold and the
vocabulary. A public checkpoint has none; then the defaults below hold.
"""

from pathlib import Path
from typing import Annotated

import msgspec

from w2c.errors import ConfigError, ModelError
from w2c_grounding.evidence import REGION_FRACTION
from w2c_grounding.wording import check_template

CARD_FILE = "grounding.json"

# What the authors' demo of CLIPSeg leads to expect; uncalibrated. Set --threshold for a public
# checkpoint. Other families have their own in `registry.FAMILIES`.
DEFAULT_THRESHOLD = 0.4
DEFAULT_TEMPLATE = "{}"


class ModelCard(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How to ask a checkpoint, and how to read its answers."""

    name: Annotated[str, msgspec.Meta(min_length=1, max_length=100)]
    template: str = DEFAULT_TEMPLATE
    threshold: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] = DEFAULT_THRESHOLD
    edge: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] = REGION_FRACTION
    """Share of a heatmap's peak at which a thing ends"""
    vocabulary: list[str] | None = None
    """Words of the training phrases that named something; None = not known"""
    compares_sizes: bool = False
    """Large and small are told by comparing what the rest of a phrase fits: see `sizes`"""
    names_of_size: tuple[str, ...] = ()
    """Names of things with a word of size in them, as `small shovel`: there it compares nothing"""
    second_look: bool = False
    """What a phrase lights is looked at again, from near, by the network of a file beside the
    weights: see `second_look`"""
    things: bool = False
    """The second look is taken at each thing of a picture, found by the network of a file, whatever
    a phrase lights: see `things`"""
    outlines: bool = False
    """Where a thing ends is drawn from near, by the network of another file: see `outline`"""


def read_card(
    directory: Path | None, fallback_name: str, fallback_threshold: float = DEFAULT_THRESHOLD
) -> ModelCard:
    """Return the card of a checkpoint directory, or one of the fallbacks where it has none.

    Raises:
        ModelError: the card is malformed.
    """
    path = None if directory is None else directory / CARD_FILE
    if path is None or not path.is_file():
        return ModelCard(name=fallback_name[-100:], threshold=fallback_threshold)
    try:
        card = msgspec.json.decode(path.read_bytes(), type=ModelCard)
        check_template(card.template)
    except (OSError, msgspec.DecodeError, UnicodeDecodeError, ConfigError) as error:
        raise ModelError(f"model card {path}: {error}") from error
    return card


def write_card(card: ModelCard, directory: Path) -> None:
    """Write the card of a checkpoint directory."""
    encoded = msgspec.json.format(msgspec.json.encode(card), indent=1)
    (directory / CARD_FILE).write_bytes(encoded + b"\n")
