"""What shows between the wires of a rack is the rack: so people mean it when they point there."""

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from w2c_sim_robot.scenes.objects.catalogue import KINDS
from w2c_sim_robot.scenes.scene import SceneObject


def fill_open_work(
    objects: Sequence[SceneObject],
    identity: npt.NDArray[np.uint8],
    parts: npt.NDArray[np.uint8],
) -> None:
    """Give the gaps of things of wires to them, in place.

    A gap is what of the room or its furniture shows within the convex outline of what is seen of
    the thing. What stands in it or before it keeps its pixels.

    Args:
        objects: Of the scene; the n-th is n in `identity`.
        identity: (h, w): 0 nothing, n = the n-th object, 255 = the robot.
        parts: (h, w): 0 no named part, which is what a gap is.
    """
    through = [0, *(n for n, item in enumerate(objects, 1) if KINDS[item.kind].furniture)]
    for number, item in enumerate(objects, start=1):
        if not KINDS[item.kind].open_work:
            continue
        rows, columns = np.nonzero(identity == number)
        if not rows.size:
            continue
        outline = cv2.convexHull(np.column_stack((columns, rows)).astype(np.int32))
        inside = np.zeros(identity.shape, np.uint8)
        cv2.fillConvexPoly(inside, outline, 1)
        gaps = (inside > 0) & np.isin(identity, through)
        identity[gaps] = number
        parts[gaps] = 0
