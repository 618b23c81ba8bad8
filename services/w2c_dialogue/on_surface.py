"""A place beside things is on the surface they stand on, and on nothing else that stands there.

Arithmetic on boxes knows only the things that were named. Where it points at the next thing, at the
robot's own hand or past the edge of the table, the nearest place on the surface is meant.
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
HOT = 0.5
"""Of the peak: cells that show the surface"""
MARGIN = 0.008
"""From the edge of what is seen of the surface, as a share of the width of the picture"""
REACH = 0.6
"""As far as a place is moved, as a share of the longer side of the first thing: farther off it is
another place"""


def look_for_surface(grounding: Grounding, frame: Frame) -> PhraseEvidence | None:
    """Return what is seen of surfaces that carry things; None where the model sees none.

    A model that does not answer sees none: the place can be shown all the same, and corrected.
    """
    try:
        seen = grounding.ground(frame, [SURFACE], "heatmaps")
    except CallError:
        return None
    return seen[0] if len(seen) == 1 and seen[0].found else None


def onto_surface(
    point: ImagePoint, objects: Sequence[SceneObject], grounding: Grounding, frame: Frame
) -> ImagePoint:
    """Return the place on the surface that is nearest to a point beside things.

    A point on one of the things stays, without a look at the picture; so does one with no surface
    near it.

    Args:
        point: In the picture [px].
        objects: The things that the point is beside, the first of them the most important one.
        grounding: Sees the surface.
        frame: The picture.
    """
    if not objects or any(inside((point.u, point.v), item.box) for item in objects):
        return point
    surface = look_for_surface(grounding, frame)
    if surface is None or surface.heatmap is None:
        return point
    free = _free(surface.heatmap)
    rows, columns = np.nonzero(free)
    if not len(rows):
        return point
    size = frame.width, frame.height
    if free[cell_at(point.u, point.v, free.shape, size)]:
        return point
    u, v = middles(rows, columns, free.shape, size)
    distance = np.hypot(u - point.u, v - point.v)
    nearest = int(np.argmin(distance))
    box = objects[0].box
    if distance[nearest] > REACH * max(box.right - box.left, box.bottom - box.top):
        return point
    return ImagePoint(float(u[nearest]), float(v[nearest]), clipped=point.clipped)


def _free(heatmap: Array) -> npt.NDArray[np.bool_]:
    """Return the cells (h, w) that show the surface and nothing of its edge."""
    hot = (heatmap >= HOT * float(heatmap.max())) & (heatmap > 0)
    cells = max(1, round(MARGIN * heatmap.shape[1]))
    kernel = np.ones((2 * cells + 1, 2 * cells + 1), dtype=np.uint8)
    # The surface goes on beyond the edge of the picture.
    inner = cv2.erode(hot.astype(np.uint8), kernel, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(inner > 0)
