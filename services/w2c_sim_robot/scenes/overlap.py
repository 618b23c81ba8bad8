"""Which bodies of a scene are inside one another, or in the floor."""

from collections.abc import Sequence

import mujoco
import numpy as np

from w2c.geometry import Vector
from w2c_sim_robot.scenes.build import add_colliders
from w2c_sim_robot.scenes.scene import SceneObject

TOLERANCE = 0.002
"""Things that rest on each other may overlap by this [m]"""


def deepest_overlap(objects: Sequence[SceneObject]) -> tuple[str, str, float] | None:
    """Return the names of the two bodies that overlap most, and by how much [m].

    The second may be `floor`. None where nothing overlaps by more than `TOLERANCE`.
    """
    spec = mujoco.MjSpec()
    for item in objects:
        x, y, z, w = item.orientation
        body = spec.worldbody.add_body(name=item.name, pos=item.position, quat=[w, x, y, z])
        add_colliders(body, item)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    low, high = _extents(model, data)
    owner = model.geom_bodyid
    worst: tuple[str, str, float] | None = None
    deepest = TOLERANCE
    for geom in range(model.ngeom):
        under = float(-low[geom, 2])
        if under > deepest:
            worst, deepest = (model.body(owner[geom]).name, "floor", under), under
    fromto = np.empty(6)
    near = (low[:, None] < high[None]).all(axis=2) & (high[:, None] > low[None]).all(axis=2)
    for first, second in np.argwhere(np.triu(near, 1)):
        if owner[first] == owner[second]:
            continue
        depth = -mujoco.mj_geomDistance(model, data, int(first), int(second), 0.01, fromto)
        if depth > deepest:
            names = (model.body(owner[first]).name, model.body(owner[second]).name)
            worst, deepest = (*names, float(depth)), float(depth)
    return worst


def _extents(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[Vector, Vector]:
    """Return the lowest and the highest corner (n, 3) of each geom along the world's axes [m]."""
    half = np.empty((model.ngeom, 3))
    for geom in range(model.ngeom):
        rotation = data.geom_xmat[geom].reshape(3, 3)
        size, kind = model.geom_size[geom], model.geom_type[geom]
        if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
            half[geom] = size[0]
        elif kind == mujoco.mjtGeom.mjGEOM_BOX:
            half[geom] = np.abs(rotation) @ size
        else:  # a cylinder or a capsule: its axis, and a disc or ball around its ends
            axis = np.abs(rotation[:, 2])
            round_ = kind == mujoco.mjtGeom.mjGEOM_CAPSULE
            rim = np.ones(3) if round_ else np.sqrt(np.clip(1.0 - axis**2, 0.0, 1.0))
            half[geom] = size[1] * axis + size[0] * rim
    return data.geom_xpos - half, data.geom_xpos + half
