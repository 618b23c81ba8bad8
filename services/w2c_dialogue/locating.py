"""Where the target is in the picture the operator sees now."""

import numpy as np

from w2c.errors import RefusedError
from w2c_dialogue.conversation import Shown
from w2c_dialogue.frames import pixels_per_cm, project
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.prompts.base import CorrectionScene


def locate(shown: Shown, frame: Frame) -> tuple[Frame, CorrectionScene]:
    """Find the target in the picture the operator sees now.

    The picture may be newer than the target's: then the target is its 3D point, projected. Without
    depth or camera pose the target stays in its own picture; without depth a centimetre stays as
    long as it was before the last correction.

    Raises:
        RefusedError: the target is not in the present picture.
    """
    point, view = shown.target.point, frame.view
    if point is None or view is None or frame.stamp_ns == shown.frame.stamp_ns:
        known = pixels_per_cm(point, shown.frame.view)
        scale = shown.pixels_per_cm if point is None else known
        return shown.frame, shown.scene((shown.target.u, shown.target.v), scale)
    scale = pixels_per_cm(point, view)
    before = shown.frame.view
    if before is not None and np.allclose(
        before.world_from_camera, view.world_from_camera, atol=1e-4
    ):
        return frame, shown.scene((shown.target.u, shown.target.v), scale)
    at = project(point, view)
    if at is None:
        raise RefusedError("The target is not in the picture you see. Name the place again.")
    return frame, shown.scene(at, scale)
