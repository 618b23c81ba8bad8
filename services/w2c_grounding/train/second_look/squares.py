"""The things of pictures, cut out, and what there is to say of them."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from w2c_grounding.second_look.crops import brought_to_width, square_around
from w2c_grounding.train.data import (
    ObjectTruth,
    PictureTruth,
    cropped,
    read_identity,
    read_picture,
    read_truth,
)

SIDE = 100
"""Of what is kept [px]: what a step cuts out of it has as many as the network reads, or few more"""
MARGIN = 0.4
"""More than at run time: a step cuts its own squares out of these, shifted and scaled"""
LEAST_VISIBLE = 0.0005
"""Of the picture: what shows less is not cut out"""
ELSEWHERE = 2
"""Boxes of each picture that nobody put around a thing"""
LEAST_INSIDE = 0.02
"""Of a box: so much of a thing in it may be what is seen in it"""


@dataclass(frozen=True)
class Cut:
    """One square."""

    item: ObjectTruth | None
    """Whose box it is; None = a box anywhere"""
    inside: frozenset[int]
    """Ids of the things that show in a box anywhere"""


@dataclass(frozen=True)
class Squares:
    """All squares of a set of pictures."""

    pixels: npt.NDArray[np.uint8]
    """(n, SIDE, SIDE, 3)"""
    cuts: tuple[Cut, ...]
    truths: tuple[PictureTruth, ...]
    of_picture: tuple[range, ...]
    """Numbers of the squares of each picture"""


def cut_out(files: Sequence[Path], seed: int, threads: int = 1) -> Squares:
    """Cut the things out of the pictures of truth files. Raises ConfigError."""
    with ThreadPoolExecutor(threads) as workers:
        numbers = range(len(files))
        parts = list(workers.map(lambda n: _of_picture(files[n], seed, n), numbers))
    ends = np.cumsum([len(cuts) for _, cuts, _ in parts])
    return Squares(
        pixels=np.concatenate([pixels for pixels, _, _ in parts]),
        cuts=tuple(cut for _, cuts, _ in parts for cut in cuts),
        truths=tuple(truth for _, _, truth in parts),
        of_picture=tuple(
            range(int(end) - len(cuts), int(end))
            for end, (_, cuts, _) in zip(ends, parts, strict=True)
        ),
    )


def _of_picture(
    path: Path, seed: int, number: int
) -> tuple[npt.NDArray[np.uint8], list[Cut], PictureTruth]:
    whole = read_truth(path)
    image, scale = brought_to_width(read_picture(path, whole))
    seen = {item.id: item.visible_pixels for item in whole.objects}
    truth = cropped(whole, whole.width, whole.height, seen)
    least = LEAST_VISIBLE * whole.width * whole.height
    cuts: list[Cut] = []
    squares = []
    for item in truth.objects:
        if item.visible_pixels >= least and item.box is not None:
            cuts.append(Cut(item, frozenset({item.id})))
            squares.append(square_around(image, [scale * one for one in item.box], SIDE, MARGIN))
    identity = read_identity(path, whole)
    rng = np.random.default_rng([seed, 5, number])
    for _ in range(ELSEWHERE):
        box = _anywhere(whole, rng)
        counts = np.bincount(identity[box[1] : box[3], box[0] : box[2]].reshape(-1), minlength=256)
        area = (box[2] - box[0]) * (box[3] - box[1])
        shown = set(np.flatnonzero(counts > LEAST_INSIDE * area).tolist())
        cuts.append(Cut(None, frozenset(shown & seen.keys())))
        squares.append(square_around(image, [scale * one for one in box], SIDE, MARGIN))
    return np.stack(squares), cuts, truth


def _anywhere(truth: PictureTruth, rng: np.random.Generator) -> tuple[int, int, int, int]:
    """Return a box of the usual sizes and shapes of things, somewhere in the picture."""
    length = truth.width * float(np.exp(rng.uniform(np.log(0.03), np.log(0.25))))
    aspect = float(np.exp(rng.uniform(-0.7, 0.7)))
    width = max(4, min(round(length * aspect**0.5), truth.width // 2))
    height = max(4, min(round(length / aspect**0.5), truth.height // 2))
    left = int(rng.integers(truth.width - width))
    top = int(rng.integers(truth.height - height))
    return left, top, left + width, top + height
