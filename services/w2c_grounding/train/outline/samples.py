"""What a model lights in pictures, cut out with the things that are there."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from w2c.errors import ConfigError
from w2c_grounding.evidence import Mask, Region
from w2c_grounding.family import Family, Heatmap, RgbImage
from w2c_grounding.outline.draws_outlines import regions_to_draw
from w2c_grounding.outline.network import LAYERS, SIDE
from w2c_grounding.outline.window import layers, window_around
from w2c_grounding.second_look.crops import brought_to_width
from w2c_grounding.sizes import SIZE_WORDS
from w2c_grounding.train.asker import FURNITURE, framed
from w2c_grounding.train.data import ROBOT, PictureTruth, read_identity, read_picture, read_truth

STORED = 96
"""Side of what is cut out [px]: a step cuts its own squares out of it, shifted and scaled"""
PHRASES = 8
"""Of a picture, one for each thing"""
MOSTLY = 0.4
"""Of a region: a thing with less of it is not what the region shows"""
FURNITURE_SHARE = 0.25
"""How often a piece of furniture is asked for"""


@dataclass(frozen=True)
class Lit:
    """A region of a heatmap, and the thing that it shows."""

    image: RgbImage
    """Brought to a width"""
    scale: float
    """Its pixels over those of the heatmap"""
    heatmap: Heatmap
    region: Region
    thing: Mask
    """(height, width) of the heatmap"""


def lit(
    family: Family[Any], path: Path, least: float, edge: float, rng: np.random.Generator
) -> Iterator[Lit]:
    """Yield what a family lights in one picture where it is asked for its things.

    Args:
        family: Asked.
        path: Of the truth file.
        least: Score of a region that counts.
        edge: Share of the peak at which a thing ends.
        rng: Chooses the phrases.

    Raises:
        ConfigError: the picture is damaged.
    """
    truth = read_truth(path)
    image = read_picture(path, truth)
    owners = read_identity(path, truth)
    phrases = _phrases(truth, rng)
    if not phrases:
        return
    small, scale = brought_to_width(image)
    for one in family.query(family.prepare(image), phrases):
        for region in regions_to_draw(one.heatmap, least, edge):
            thing = _shown(owners, region)
            if thing is not None:
                yield Lit(small, scale, one.heatmap, region, owners == thing)


def collect(
    family: Family[Any],
    files: Sequence[Path],
    least: float,
    edge: float,
    seed: int,
    report: Callable[[str], None],
) -> npt.NDArray[np.uint8]:
    """Return squares (n, STORED, STORED, LAYERS + 1); the last layer is the thing, 255 where it is.

    Raises:
        ConfigError: a picture is damaged, or nothing was lit.
    """
    squares = []
    for number, path in enumerate(files, start=1):
        rng = np.random.default_rng([seed, 8, number])
        squares += [_square(one) for one in lit(family, path, least, edge, rng)]
        if number % 500 == 0:
            report(f"{number} of {len(files)} pictures asked, {len(squares)} things lit")
    if not squares:
        raise ConfigError(
            f"the checkpoint lights nothing in {len(files)} pictures; train it first, with: "
            "w2c train grounding"
        )
    return np.stack(squares)


def _square(one: Lit) -> npt.NDArray[np.uint8]:
    window = window_around(one.region, one.scale).widened(STORED / SIDE)
    read = layers(one.image, one.heatmap, one.region, window, STORED)
    thing = window.of_map(one.thing, STORED)
    square = np.empty((STORED, STORED, LAYERS + 1), np.uint8)
    square[..., :LAYERS] = read
    square[..., LAYERS] = np.rint(255.0 * thing)
    return square


def _phrases(truth: PictureTruth, rng: np.random.Generator) -> list[str]:
    """Return a phrase for each of some things, without words of size: those are compared."""
    things = [
        item
        for item in truth.clearly_visible()
        if item.kind not in FURNITURE or rng.random() < FURNITURE_SHARE
    ]
    phrases = []
    for number in rng.permutation(len(things))[:PHRASES].tolist():
        plain = [text for text in things[number].phrases if SIZE_WORDS.isdisjoint(text.split())]
        if plain:
            phrases.append(framed(plain[int(rng.integers(len(plain)))], rng))
    return phrases


def _shown(owners: npt.NDArray[np.uint8], region: Region) -> int | None:
    """Return the id of what a region shows; None where that is nothing, or the robot."""
    inside = owners[region.top : region.bottom, region.left : region.right][region.mask]
    counts = np.bincount(inside, minlength=256)
    counts[[0, ROBOT]] = 0
    thing = int(counts.argmax())
    return thing if counts[thing] >= MOSTLY * len(inside) else None
