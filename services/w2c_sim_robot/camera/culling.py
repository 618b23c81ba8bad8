"""Leave out what a camera cannot see: MuJoCo draws every shape of the model, in sight or not."""

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np
import numpy.typing as npt

LEFT_OUT = 5
"""Group of shapes for what is left out of a picture"""


def may_be_seen(
    model: mujoco.MjModel, data: mujoco.MjData, camera: int, aspect: float
) -> npt.NDArray[np.bool_]:
    """Tell of each shape (n,) whether its bounding sphere reaches into a camera's field of view.

    Args:
        model: With the shapes.
        data: Their poses, and the camera's.
        camera: Its number.
        aspect: Width over height of the picture.
    """
    in_camera = (data.geom_xpos - data.cam_xpos[camera]) @ data.cam_xmat[camera].reshape(3, 3)
    ahead = -in_camera[:, 2]
    radius = model.geom_rbound
    half_height = float(np.radians(model.cam_fovy[camera])) / 2.0
    half_width = float(np.arctan(np.tan(half_height) * aspect))
    seen = ahead > -radius
    for axis, half in ((0, half_width), (1, half_height)):
        # Distance beyond the plane through the eye and that side of the picture.
        beyond = np.abs(in_camera[:, axis]) * np.cos(half) - ahead * np.sin(half)
        seen &= beyond < radius
    return np.asarray(seen | (radius == 0.0))  # a plane has no bounding sphere


@contextmanager
def culled(
    model: mujoco.MjModel, option: mujoco.MjvOption, seen: npt.NDArray[np.bool_] | None
) -> Iterator[None]:
    """Put what is not seen into a group that is not drawn; None: draw everything.

    The model is as it was afterwards.
    """
    if seen is None:
        yield
        return
    usual = model.geom_group.copy()
    option.geomgroup[LEFT_OUT] = 0
    try:
        model.geom_group[~seen] = LEFT_OUT
        yield
    finally:
        model.geom_group[:] = usual
