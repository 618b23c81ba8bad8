"""Where the head camera is, and what its rays meet in a model; no graphics context needed."""

from dataclasses import dataclass

import mujoco
import numpy as np

from w2c.geometry import Intrinsics, Matrix, transform
from w2c.messages import Array
from w2c_sim_robot.model import HEAD_CAMERA, ROBOT_GROUP, WORLD_GROUP

_FROM_MUJOCO = np.diag([1.0, -1.0, -1.0])
"""A camera of MuJoCo looks along -z with y up, an optical frame along z with y down"""
_VISIBLE = np.zeros(6, np.uint8)
"""Groups of shapes that the camera's pictures show"""
_VISIBLE[[WORLD_GROUP, ROBOT_GROUP]] = 1


@dataclass(frozen=True)
class Hits:
    """What rays met."""

    rays: Array
    """(n, 3) unit, in the world"""
    geoms: Array
    """(n,) indices of shapes; -1 = nothing"""
    distances: Array
    """(n,) along the rays [m]; -1 = nothing"""
    normals: Array
    """(n, 3) unit, towards the camera, in the world"""


def world_from_camera(data: mujoco.MjData) -> Matrix:
    """Return the (4, 4) pose of the optical frame: x right, y down, z forward."""
    camera = data.camera(HEAD_CAMERA)
    return transform(camera.xmat.reshape(3, 3) @ _FROM_MUJOCO, camera.xpos)


def cast_rays(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    intrinsics: Intrinsics,
    pixels: Array,
    farthest: float,
) -> Hits:
    """Look along the rays of pixels.

    Args:
        model: With the camera.
        data: Its poses, those of cameras too.
        intrinsics: Of the camera.
        pixels: (n, 2) u, v [px].
        farthest: Nothing is met beyond [m].
    """
    pose = world_from_camera(data)
    rays = intrinsics.rays(pixels[:, 0], pixels[:, 1]) @ pose[:3, :3].T
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    count = len(rays)
    geoms = np.full(count, -1, np.int32)
    distances, normals = np.zeros(count), np.zeros((count, 3))
    mujoco.mj_multiRay(
        model, data, pose[:3, 3], rays.ravel(), _VISIBLE, 1, -1,
        geoms, distances, normals.ravel(), count, farthest,
    )  # fmt: skip
    geoms[distances < 0.0] = -1
    away = np.sum(normals * rays, axis=1) > 0.0
    return Hits(rays, geoms, distances, np.where(away[:, None], -normals, normals))
