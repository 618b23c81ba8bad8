"""How many of the things of pictures are found, before anything is asked."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from w2c_grounding.boxes import intersection_over_union
from w2c_grounding.family import Family, ScoredBox
from w2c_grounding.things.proposals import Thing
from w2c_grounding.train.asker import FURNITURE
from w2c_grounding.train.data import read_picture, read_truth

WELL = 0.5
"""Intersection over union of boxes of the same thing"""


def recall(
    family: Family[Any], find_things: Callable[[Any], Sequence[Thing]], files: Sequence[Path]
) -> dict[str, float]:
    """Return the share of clearly visible things that have a box, and the boxes of a picture.

    Args:
        family: Sees the pictures.
        find_things: Finds things in what it keeps of one.
        files: Truth files.

    Raises:
        ConfigError: a picture is damaged.
    """
    found: list[bool] = []
    counts: list[int] = []
    for path in files:
        truth = read_truth(path)
        image = read_picture(path, truth)
        boxes = [_box(one, truth.width, truth.height) for one in find_things(family.prepare(image))]
        counts.append(len(boxes))
        for item in truth.clearly_visible():
            if item.kind in FURNITURE or item.box is None:
                continue
            wanted = ScoredBox(*item.box, 1.0)
            found.append(any(intersection_over_union(box, wanted) >= WELL for box in boxes))
    return {
        "things.found": float(np.mean(found)) if found else float("nan"),
        "things.of_a_picture": float(np.mean(counts)) if counts else float("nan"),
    }


def _box(thing: Thing, width: int, height: int) -> ScoredBox:
    left, top, right, bottom = thing.box
    return ScoredBox(left * width, top * height, right * width, bottom * height, thing.score)
