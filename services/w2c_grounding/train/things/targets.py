"""What the network of things should say of a picture. Pure functions."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt
import torch

from w2c_grounding.train.asker import FURNITURE
from w2c_grounding.train.data import ROBOT, PictureTruth

LEAST_VISIBLE = 0.0004
"""Of the picture: what shows less is neither a thing nor none"""


@dataclass(frozen=True)
class Targets:
    """Of several pictures."""

    things: torch.Tensor
    """(n, rows, columns) 1 where a thing is seen, 0 where none is, -1 where it does not matter"""
    boxes: torch.Tensor
    """(n, rows, columns, 4) of that thing; left, top, right, bottom as shares of the sides"""
    weights: torch.Tensor
    """(n, rows, columns) of each place inside a thing; those of a thing sum to 1"""


def targets_of(owners: npt.NDArray[np.uint8], truths: Sequence[PictureTruth], rows: int) -> Targets:
    """Return the targets of pictures whose pixels have these owners.

    Args:
        owners: (n, side, side) ids of objects; 0 nothing, 255 the robot.
        truths: Of what the pictures show.
        rows: Of the targets; as many columns.
    """
    side = owners.shape[1]
    step = side // rows
    seen = owners[:, step // 2 :: step, step // 2 :: step]
    things = np.zeros(seen.shape, np.float32)
    boxes = np.zeros((*seen.shape, 4), np.float32)
    weights = np.zeros(seen.shape, np.float32)
    for number, truth in enumerate(truths):
        kinds = {item.id: item.kind for item in truth.objects}
        for identity in np.unique(seen[number]):
            if identity in (0, ROBOT) or kinds.get(int(identity)) in FURNITURE:
                continue
            here = seen[number] == identity
            mask = (owners[number] == identity).astype(np.uint8)
            if cv2.countNonZero(mask) < LEAST_VISIBLE * side * side:
                things[number][here] = -1.0
                continue
            left, top, width, height = cv2.boundingRect(mask)
            things[number][here] = 1.0
            boxes[number][here] = np.array([left, top, left + width, top + height]) / side
            weights[number][here] = 1.0 / np.count_nonzero(here)
    return Targets(*(torch.from_numpy(one) for one in (things, boxes, weights)))
