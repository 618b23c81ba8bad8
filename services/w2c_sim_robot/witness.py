"""What an impartial witness of a simulation sees: surfaces behind pixels, and who touches whom.

Made from the scene and from the positions that the simulator tells as truth. For judging only: no
service of the product asks it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from w2c.errors import ConfigError
from w2c.geometry import (
    Intrinsics,
    Matrix,
    Vector,
    apply,
    intrinsics_from_fov,
    inverse,
    transform,
)
from w2c.messages import Array
from w2c_sim_robot import talos
from w2c_sim_robot.head_camera import Hits, cast_rays, world_from_camera
from w2c_sim_robot.model import (
    CAMERA_FOVY_DEG,
    CAMERA_SIZE,
    ROBOT_CONTYPE,
    build_spec,
    ready_configuration,
)
from w2c_sim_robot.scenes import scene as scenes
from w2c_sim_robot.scenes.scene import Scene, SceneObject
from w2c_sim_robot.urdf import overlapping_links

FARTHEST = 20.0
"""Nothing is looked for beyond [m]."""
FLOOR = "floor"
ROBOT = "robot"


@dataclass(frozen=True)
class Surface:
    """The first visible surface behind a pixel of the head camera."""

    owner: str
    """Name of the object, `floor` (walls too) or `robot`"""
    point: Vector
    """(3,) in the world [m]"""
    normal: Vector
    """(3,) towards the camera"""


@dataclass(frozen=True)
class Contact:
    """Two bodies that touch, by name: links of the robot, objects, or `floor`."""

    first: str
    second: str
    depth: float
    """How far they overlap [m]"""


class Witness:
    """The model of robot and scene in the positions of one moment. Give it some with `pose`."""

    def __init__(self, scene: Scene | Path) -> None:
        """Build the model. Raises ConfigError for a bad scene file."""
        self._scene = scenes.load(scene) if isinstance(scene, Path) else scene
        spec = build_spec(self._scene)
        for geom in spec.geoms:  # the simulator's robot passes through itself; this one does not
            if geom.contype == ROBOT_CONTYPE:
                geom.conaffinity |= ROBOT_CONTYPE
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        model = self._model
        robot = model.body_rootid == model.body(talos.BASE_LINK).id
        names = [model.body(index).name for index in range(model.nbody)]
        names[0] = FLOOR
        self._names = names
        self._owners = [ROBOT if own else name for own, name in zip(robot, names, strict=True)]
        self._robot = robot
        self._overlapping = overlapping_links()
        self._natural: dict[tuple[str, str], float] = {}
        self.pose(ready_configuration(model))
        self._natural = {
            (contact.first, contact.second): contact.depth
            for contact in self.contacts()
            if contact.second in self.links
        }

    @property
    def model(self) -> mujoco.MjModel:
        """Return the MuJoCo model."""
        return self._model

    @property
    def effectors(self) -> dict[str, int]:
        """Return the links of feet and hands, and which they belong to: feet first, left first."""
        links = (*talos.SOLE_FRAMES, talos.WRIST_SENSOR_LINK, talos.HAND_FRAMES[1])
        found: dict[str, int] = {}
        for effector, link in enumerate(links):
            members = {self._model.body(link).id}
            for body in range(self._model.nbody):  # parents come before children in MuJoCo
                if int(self._model.body_parentid[body]) in members:
                    members.add(body)
            found |= {self._names[body]: effector for body in members}
        return found

    @property
    def links(self) -> frozenset[str]:
        """Return the links of the robot."""
        return frozenset(name for name, own in zip(self._names, self._robot, strict=True) if own)

    @property
    def objects(self) -> tuple[SceneObject, ...]:
        """Return the things of the scene, as they were placed."""
        return self._scene.objects

    @property
    def size(self) -> tuple[int, int]:
        """Return width and height of the head camera's pictures [px]."""
        return CAMERA_SIZE

    @property
    def intrinsics(self) -> Intrinsics:
        """Return those of the head camera."""
        return intrinsics_from_fov(*CAMERA_SIZE, float(np.radians(CAMERA_FOVY_DEG)))

    def pose(self, generalized_position: Array) -> None:
        """Put everything where the simulator has it.

        Raises:
            ConfigError: the simulator has another model, so another scene.
        """
        if generalized_position.shape != (self._model.nq,):
            raise ConfigError(
                f"{generalized_position.size} coordinates, this model has {self._model.nq}: the "
                "simulator was started with another scene"
            )
        self._data.qpos[:] = generalized_position
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)

    def world_from_object(self, name: str) -> Matrix:
        """Return the (4, 4) pose of a thing; origin in the middle of its underside."""
        self._scene.object(name)
        body = self._data.body(name)
        return transform(body.xmat.reshape(3, 3), body.xpos)

    def world_from_camera(self) -> Matrix:
        """Return the (4, 4) pose of the optical frame: x right, y down, z forward."""
        return world_from_camera(self._data)

    def project(self, point: Vector) -> tuple[float, float] | None:
        """Return the pixel of a point (3,) of the world; None where it is not in the picture."""
        in_camera = apply(inverse(self.world_from_camera()), point)
        if in_camera[2] < 0.05:
            return None
        u, v = self.intrinsics.pixel_from_point(in_camera)
        return (u, v) if 0.0 <= u <= self.size[0] and 0.0 <= v <= self.size[1] else None

    def surface(self, u: float, v: float) -> Surface | None:
        """Return what a pixel of the head camera shows; None where it shows nothing."""
        found = self._cast(np.array([[u, v]]))
        index = int(found.geoms[0])
        if index < 0:
            return None
        origin = self.world_from_camera()[:3, 3]
        point = origin + found.distances[0] * found.rays[0]
        return Surface(self._owner(index), point, found.normals[0])

    def owners(self, pixels: Array) -> list[str]:
        """Return what pixels (n, 2) of the head camera show: as `Surface.owner`, "" = nothing."""
        return [self._owner(int(geom)) if geom >= 0 else "" for geom in self._cast(pixels).geoms]

    def contacts(self) -> list[Contact]:
        """Return who touches whom, deepest first; one entry a pair, the robot's link first.

        The robot's shapes are convex hulls, some of which overlap in a natural posture: of two of
        its own links only what overlaps more than when it stands ready counts, and is the depth.
        Links whose shapes always overlap, by the word of their maker, do not count.
        """
        mujoco.mj_collision(self._model, self._data)
        deepest: dict[tuple[str, str], float] = {}
        for (one, other), distance in zip(
            self._model.geom_bodyid[self._data.contact.geom], self._data.contact.dist, strict=True
        ):
            first, second = sorted((int(one), int(other)), key=lambda b: (not self._robot[b], b))
            pair = (self._names[first], self._names[second])
            if frozenset(pair) in self._overlapping:
                continue
            deepest[pair] = max(deepest.get(pair, 0.0), -float(distance))
        found = [
            Contact(*pair, depth - self._natural.get(pair, 0.0)) for pair, depth in deepest.items()
        ]
        kept = [c for c in found if c.depth > 0.0 or (c.first, c.second) not in self._natural]
        return sorted(kept, key=lambda contact: -contact.depth)

    def _owner(self, geom: int) -> str:
        return self._owners[int(self._model.geom_bodyid[geom])]

    def _cast(self, pixels: Array) -> Hits:
        """Look along the rays of pixels (n, 2)."""
        return cast_rays(self._model, self._data, self.intrinsics, pixels, FARTHEST)
