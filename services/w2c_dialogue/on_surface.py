"""A place beside things is on the surface they stand on, and on nothing else that stands there.

Arithmetic on boxes knows only the things that were named. Where it points at the next thing, at the
robot's own hand or past the edge of the table, the nearest place on the surface is meant that is on
the same side of the thing. Of a floor vision models see nothing: there the nearest place is meant
that no thing takes.
"""

import math
from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from w2c.errors import CallError
from w2c.messages import Box, PhraseEvidence
from w2c_dialogue.cells import cell_at
from w2c_dialogue.expressions import ImagePoint
from w2c_dialogue.heat import hot, inner, nearest
from w2c_dialogue.interfaces import Frame, Grounding
from w2c_dialogue.prompts.base import SceneObject
from w2c_dialogue.sight import inside

SURFACES = ("surface", "table", "counter", "shelf")
"""What the vision model is asked for. Which of these words it takes a surface for depends more on
what the surface looks like than on what it is, so their heat is put together"""
SMALLEST = 0.03
"""Share of the picture: less is no surface that things stand on"""
THINGS = tuple(
    f"{colour} thing"
    for colour in (
        "red", "orange", "yellow", "green", "blue", "turquoise", "purple", "pink", "brown", "black",
        "grey", "white",
    )
)  # fmt: skip
"""What it is asked for where it sees no surface: whatever stands there has a colour"""
GROUND = 0.25
"""Share of the picture: what is of one colour and larger is the ground itself, no thing on it"""
REACH = 0.6
"""As far as a place is moved, as a share of the longer side of the first thing: farther off it is
another place. Between two things it may go to either of them"""


def look_for_surface(grounding: Grounding, frame: Frame) -> npt.NDArray[np.bool_] | None:
    """Return the cells (h, w) that show surfaces that carry things; None: no surface is seen.

    Raises:
        CallError: the model does not answer.
    """
    heatmaps = [one.heatmap for one in _look(grounding, frame, SURFACES) if one.heatmap is not None]
    if not heatmaps:
        return None
    seen = hot(np.maximum.reduce(heatmaps))
    return seen if seen.mean() >= SMALLEST else None


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
    if free is None:
        return point
    size = frame.width, frame.height
    boxes = [item.box for item in objects]
    kept = _on_the_same_side(free, point, boxes, size)
    reach = REACH * max(boxes[0].right - boxes[0].left, boxes[0].bottom - boxes[0].top)
    if len(boxes) == 2:
        gap = _gap(point, *boxes)
        hull = _hull(boxes, kept.shape, size)
        # "Between them, but a little behind" is outside.
        if gap > 0.0 and hull[cell_at(point.u, point.v, hull.shape, size)]:
            kept &= hull
            reach = max(reach, 0.5 * gap)
    for cells in (kept & _level(point, boxes, kept.shape, size), kept):
        place = nearest(cells, point, size)
        if place is not None and math.dist((place.u, place.v), (point.u, point.v)) <= reach:
            return place
    return point


def _on_the_same_side(
    cells: npt.NDArray[np.bool_],
    point: ImagePoint,
    boxes: Sequence[Box],
    size: tuple[int, int],
) -> npt.NDArray[np.bool_]:
    """Return those of the cells (h, w) that are on the sides of the things that a point is on."""
    kept = cells.copy()
    for box in boxes:
        top, left, bottom, right = _edges(box, cells.shape, size)
        # The cell of the point itself is always kept, also where it is the one of the edge.
        if point.u < box.left:
            kept[:, left + 1 :] = False
        elif point.u >= box.right:
            kept[:, :right] = False
        if point.v < box.top:
            kept[top + 1 :] = False
        elif point.v >= box.bottom:
            kept[:bottom] = False
    return kept


def _level(
    point: ImagePoint, boxes: Sequence[Box], shape: tuple[int, ...], size: tuple[int, int]
) -> npt.NDArray[np.bool_]:
    """Return the cells (h, w) that are level with the things that a point is level with.

    What is in front of a thing, and a little to the left, nobody calls left of it.
    """
    cells = np.ones(shape, np.bool_)
    for box in boxes:
        top, left, bottom, right = _edges(box, shape, size)
        if box.top <= point.v < box.bottom:
            cells[:top] = cells[bottom + 1 :] = False
        elif box.left <= point.u < box.right:
            cells[:, :left] = cells[:, right + 1 :] = False
    return cells


def _edges(box: Box, shape: tuple[int, ...], size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return the cells of the edges of a box: rows and columns of its first corner and its last."""
    return (
        *cell_at(box.left, box.top, shape, size),
        *cell_at(box.right, box.bottom, shape, size),
    )


def _gap(point: ImagePoint, one: Box, other: Box) -> float:
    """Return the width of the gap of two boxes that a point is in; 0 outside of it [px].

    They may stand side by side or one above the other.
    """
    across = min(one.right, other.right), max(one.left, other.left), point.u
    along = min(one.bottom, other.bottom), max(one.top, other.top), point.v
    return max((end - start for start, end, at in (across, along) if start <= at < end), default=0)


def _hull(
    boxes: Sequence[Box], shape: tuple[int, ...], size: tuple[int, int]
) -> npt.NDArray[np.bool_]:
    """Return the cells (h, w) of the smallest convex area around boxes [px]."""
    corners = [
        cell_at(u, v, shape, size)[::-1]
        for box in boxes
        for u in (box.left, box.right)
        for v in (box.top, box.bottom)
    ]
    area = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(area, cv2.convexHull(np.array(corners, np.int32)), 1)
    return area > 0


def _free_places(grounding: Grounding, frame: Frame) -> npt.NDArray[np.bool_] | None:
    """Return the cells (h, w) where nothing stands, on surfaces if there are any; None: unknown.

    Raises:
        CallError: the model does not answer. It is not asked again.
    """
    surface = look_for_surface(grounding, frame)
    if surface is not None:
        return inner(surface)
    taken = [
        _things(hot(one.heatmap))
        for one in look_for_things(grounding, frame)
        if one.heatmap is not None
    ]
    return inner(~np.logical_or.reduce(taken)) if taken else None


def _things(cells: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return the cells (h, w) of one colour without the regions that are too large for a thing."""
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(cells.astype(np.uint8))
    small = statistics[:, cv2.CC_STAT_AREA] <= GROUND * cells.size
    small[0] = False  # what is not hot
    return np.asarray(small[labels])
