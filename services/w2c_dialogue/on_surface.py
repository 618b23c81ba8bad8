"""A place beside things is on the surface they stand on, and on nothing else that stands there.

Arithmetic on boxes knows only the things that were named. Where it points at the next thing, at the
robot's own hand or past the edge of the table, the nearest place on the surface is meant. Of a
floor vision models see nothing: there the nearest place is meant that no thing takes.
"""

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from w2c.errors import CallError
from w2c.messages import Array, PhraseEvidence
from w2c_dialogue.cells import cell_at, middles
from w2c_dialogue.expressions import ImagePoint
from w2c_dialogue.interfaces import Frame, Grounding
from w2c_dialogue.prompts.base import SceneObject
from w2c_dialogue.sight import inside

SURFACE = "surface"
"""What the vision model is asked for: a table, a counter, a board of a shelf"""
THINGS = tuple(
    f"{colour} thing"
    for colour in (
        "red", "orange", "yellow", "green", "blue", "turquoise", "purple", "pink", "brown", "black",
        "grey", "white",
    )
)  # fmt: skip
"""What it is asked for where it sees no surface: whatever stands there has a colour"""
HOT = 0.5
"""Of the peak: cells that show what was asked for"""
MARGIN = 0.008
"""From the edge of what is seen of the surface, as a share of the width of the picture"""
REACH = 0.6
"""As far as a place is moved, as a share of the longer side of the first thing: farther off it is
another place"""


def look_for_surface(grounding: Grounding, frame: Frame) -> PhraseEvidence | None:
    """Return what is seen of surfaces that carry things; None: of none. Raises CallError."""
    seen = _look(grounding, frame, [SURFACE])
    return seen[0] if len(seen) == 1 else None


def look_for_things(grounding: Grounding, frame: Frame) -> list[PhraseEvidence]:
    """Return what is seen of all things, whatever they are. Raises CallError."""
    return _look(grounding, frame, THINGS)


def _look(grounding: Grounding, frame: Frame, phrases: Sequence[str]) -> list[PhraseEvidence]:
    return [one for one in grounding.ground(frame, phrases, "heatmaps") if one.found]


def onto_surface(
    point: ImagePoint, objects: Sequence[SceneObject], grounding: Grounding, frame: Frame
) -> ImagePoint:
    """Return the place on the surface that is nearest to a point beside things.

    A point on one of the things stays, without a look at the picture; so does one with no surface
    near it, and one of which a silent model says nothing: it can be shown all the same, and
    corrected.

    Args:
        point: In the picture [px].
        objects: The things that the point is beside, the first of them the most important one.
        grounding: Sees the surface, or what stands on the floor.
        frame: The picture.
    """
    if not objects or any(inside((point.u, point.v), item.box) for item in objects):
        return point
    try:
        free = _free_places(grounding, frame)
    except CallError:
        return point
    if free is None or not free.any():
        return point
    size = frame.width, frame.height
    if free[cell_at(point.u, point.v, free.shape, size)]:
        return point
    rows, columns = np.nonzero(free)
    u, v = middles(rows, columns, free.shape, size)
    distance = np.hypot(u - point.u, v - point.v)
    nearest = int(np.argmin(distance))
    box = objects[0].box
    if distance[nearest] > REACH * max(box.right - box.left, box.bottom - box.top):
        return point
    return ImagePoint(float(u[nearest]), float(v[nearest]), clipped=point.clipped)


def _free_places(grounding: Grounding, frame: Frame) -> npt.NDArray[np.bool_] | None:
    """Return the cells (h, w) where nothing stands, on surfaces if there are any; None: unknown.

    Raises:
        CallError: the model does not answer. It is not asked again.
    """
    surface = look_for_surface(grounding, frame)
    if surface is not None:
        return None if surface.heatmap is None else _inner(_hot(surface.heatmap))
    taken = [
        _hot(one.heatmap) for one in look_for_things(grounding, frame) if one.heatmap is not None
    ]
    return _inner(~np.logical_or.reduce(taken)) if taken else None


def _hot(heatmap: Array) -> npt.NDArray[np.bool_]:
    return np.asarray((heatmap >= HOT * float(heatmap.max())) & (heatmap > 0))


def _inner(cells: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return the cells (h, w) that are not near the edge of the others."""
    width = max(1, round(MARGIN * cells.shape[1]))
    kernel = np.ones((2 * width + 1, 2 * width + 1), dtype=np.uint8)
    # A surface goes on beyond the edge of the picture.
    inner = cv2.erode(cells.astype(np.uint8), kernel, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(inner > 0)
