"""What a perfect depth camera would see of a random scene, and the truth behind single pixels.

Rays are cast through the centres of pixels: no graphics context, no depth buffer to round, and the
surface that a ray meets tells its normal. Robots stand still, on both feet, in random postures.
"""

import os
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import mujoco
import numpy as np

from w2c.errors import ConfigError
from w2c.geometry import (
    Intrinsics,
    Matrix,
    base_from_midfeet,
    intrinsics_from_fov,
    inverse,
    quaternion_from_rotation,
    transform,
)
from w2c.messages import Array
from w2c_sim_robot import talos
from w2c_sim_robot.head_camera import cast_rays, world_from_camera
from w2c_sim_robot.model import (
    CAMERA_FOVY_DEG,
    CAMERA_SIZE,
    build_model,
)
from w2c_sim_robot.scenes.random_scene import random_scene
from w2c_sim_robot.scenes.scene import Scene

FARTHEST = 10.0
"""No depth camera sees farther [m]"""
SPREAD = {
    "head_1_joint": 0.15,
    "head_2_joint": 0.4,
    "torso_1_joint": 0.25,
    "torso_2_joint": 0.08,
    **dict.fromkeys(talos.LEFT_ARM + talos.RIGHT_ARM, 0.25),
}
"""How far joints are from their angles of the standing robot, at most [rad]"""
KNEE_BEND = 0.15
"""Deeper in the knees than ready, at most; ankles and hips keep the trunk where it leans [rad]"""
ROOM, ROBOT = "room", "robot"
"""What pixels may show beside things of the scene, with the words for how a thing carries"""


@dataclass(frozen=True)
class Survey:
    """One picture of one scene, exact."""

    position: Array
    """(n,) true joint angles in the order of the description [rad]"""
    intrinsics: Intrinsics
    depth: Array
    """(h, w) float32 z-depth through the centres of pixels [m]; 0 = nothing within ten metres"""
    world_from_camera: Matrix
    """(4, 4), the world midway between the soles"""
    pixels: Array
    """(k, 2) u, v anywhere in the picture [px], never on the robot"""
    points: Array
    """(k, 3) where the rays of the pixels meet something, in the camera frame [m]; NaN: nothing"""
    normals: Array
    """(k, 3) of the surfaces there, towards the camera, in the camera frame"""
    names: tuple[str, ...]
    """(k,) of the things, `room` for floor and walls"""
    supports: tuple[str, ...]
    """(k,) how they carry: carries, slides, fragile ..., or `room`"""


def kept_survey(seed: int, count: int, directory: str) -> Survey:
    """Return a survey from a directory, or make it and keep it there.

    Its file is named after the scene as well as the seed. Who changes how things are built, and
    not which things are in a scene, has to empty the directory.

    Raises:
        ConfigError: as `survey`, or the directory cannot be written.
    """
    code = zlib.crc32(msgspec.json.encode(random_scene(seed), enc_hook=str))
    path = Path(directory) / f"{seed}-{count}-{code:08x}.npz"
    try:
        if path.exists():
            return _load(path)
        made = survey(seed, count)
        path.parent.mkdir(parents=True, exist_ok=True)
        # Renamed when it is whole: one who is killed leaves no half of a file that looks whole.
        partial = path.with_suffix(f".{os.getpid()}.npz")
        arrays: dict[str, Any] = {name: np.asarray(v) for name, v in vars(made).items()}
        np.savez_compressed(partial, **arrays)
        partial.replace(path)
    except (OSError, ValueError, KeyError) as error:
        raise ConfigError(f"{path}: {error}; empty the directory, or choose another") from error
    return made


def _load(path: Path) -> Survey:
    with np.load(path) as stored:
        return Survey(
            position=stored["position"],
            intrinsics=Intrinsics(*stored["intrinsics"].tolist()),
            depth=stored["depth"],
            world_from_camera=stored["world_from_camera"],
            pixels=stored["pixels"],
            points=stored["points"],
            normals=stored["normals"],
            names=tuple(stored["names"].tolist()),
            supports=tuple(stored["supports"].tolist()),
        )


def survey(seed: int, count: int, *, size: tuple[int, int] = CAMERA_SIZE) -> Survey:
    """Return the picture of the scene of a seed, with the truth behind `count` random pixels.

    Raises:
        ConfigError: a seed below zero, less than one pixel, or a picture without pixels.
    """
    if seed < 0 or count < 1 or min(size) < 1:
        raise ConfigError(
            f"survey of seed {seed}, {count} pixels of {size}: expected a seed of 0 or more, at "
            "least one pixel, and a picture that is not empty"
        )
    scene = random_scene(seed)
    return _Surveyor(scene, np.random.default_rng([seed, 21]), size).survey(count)


class _Surveyor:
    """One scene with a robot in one posture."""

    def __init__(self, scene: Scene, rng: np.random.Generator, size: tuple[int, int]) -> None:
        self._scene, self._rng = scene, rng
        self._width, self._height = size
        self._intrinsics = intrinsics_from_fov(*size, float(np.radians(CAMERA_FOVY_DEG)))
        self._model = build_model(scene)
        self._data = mujoco.MjData(self._model)
        self._position = self._pose()
        self._world_from_camera = world_from_camera(self._data)

    def survey(self, count: int) -> Survey:
        """Look at all pixels, and closer at some."""
        rows, columns = np.mgrid[0 : self._height, 0 : self._width]
        centres = np.column_stack([columns.ravel() + 0.5, rows.ravel() + 0.5])
        depth, _, geoms = self._cast(centres)
        pixels, points, normals, met = self._sample(count, self._owners(geoms) != ROBOT)
        owners = self._owners(met)
        supports = {item.name: str(item.support) for item in self._scene.objects}
        return Survey(
            position=self._position,
            intrinsics=self._intrinsics,
            depth=depth.reshape(self._height, self._width).astype(np.float32),
            world_from_camera=self._world_from_camera,
            pixels=pixels,
            points=points,
            normals=normals,
            names=tuple(str(name) for name in owners),
            supports=tuple(supports.get(str(name), ROOM) for name in owners),
        )

    def _sample(self, count: int, free: Array) -> tuple[Array, Array, Array, Array]:
        """Return pixels (k, 2), points and normals (k, 3) there, and the geoms that are met (k,).

        `free` (h w,) are the pixels whose centre shows no robot.
        """
        candidates = np.flatnonzero(free)
        if not len(candidates):
            raise ConfigError("the robot's arms hide the whole picture; choose another seed")
        chosen = candidates[self._rng.integers(len(candidates), size=8 * count)]
        corner = np.column_stack([chosen % self._width, chosen // self._width])
        pixels = corner + self._rng.uniform(0.0, 1.0, corner.shape)
        depth, normals, geoms = self._cast(pixels)
        off_robot = np.flatnonzero(self._owners(geoms) != ROBOT)[:count]
        pixels, depth = pixels[off_robot], depth[off_robot]
        points = depth[:, None] * self._intrinsics.rays(*pixels.T)
        points[depth <= 0.0] = np.nan
        return pixels, points, normals[off_robot], geoms[off_robot]

    def _cast(self, pixels: Array) -> tuple[Array, Array, Array]:
        """Return z-depths (k,) [m], 0 = nothing; normals (k, 3) in the camera frame; geoms (k,)."""
        hits = cast_rays(self._model, self._data, self._intrinsics, pixels, FARTHEST)
        forward = hits.rays @ self._world_from_camera[:3, 2]
        depth = np.where(hits.distances > 0.0, hits.distances * forward, 0.0)
        return depth, hits.normals @ self._world_from_camera[:3, :3], hits.geoms

    def _owners(self, geoms: Array) -> Array:
        """Return the names (k,) of the things that geoms (k,) belong to; -1 is the room too."""
        model = self._model
        names = np.array([ROOM] * model.ngeom + [ROOM], dtype=object)
        robot = model.body(talos.BASE_LINK).id
        names[:-1][model.body_rootid[model.geom_bodyid] == robot] = ROBOT
        for item in self._scene.objects:
            names[:-1][model.geom_bodyid == model.body(item.name).id] = item.name
        return np.asarray(names[geoms])

    def _pose(self) -> Array:
        """Bend the robot, put the world midway between its soles; return the joint angles (n,)."""
        angles = dict(talos.READY)
        for name, spread in SPREAD.items():
            angles[name] += self._rng.uniform(-spread, spread)
        bend = self._rng.uniform(0.0, KNEE_BEND)
        for leg in (talos.LEFT_LEG, talos.RIGHT_LEG):
            for name, share in zip(leg[2:5], (-1.0, 2.0, -1.0), strict=True):
                angles[name] += share * bend
        data = self._data
        data.qpos[:] = self._model.qpos0
        for name, angle in angles.items():
            low, high = self._model.joint(name).range
            data.joint(name).qpos = np.clip(angle, low, high)
        base = self._model.joint("base").qposadr[0]
        data.qpos[base : base + 7] = (0, 0, 0, 1, 0, 0, 0)
        mujoco.mj_kinematics(self._model, data)
        left, right = (
            transform(data.body(name).xmat.reshape(3, 3), data.body(name).xpos)
            for name in talos.SOLE_FRAMES
        )
        world_from_base = inverse(base_from_midfeet(left, right))
        quaternion = quaternion_from_rotation(world_from_base[:3, :3])
        data.qpos[base : base + 3] = world_from_base[:3, 3]
        data.qpos[base + 3 : base + 7] = np.roll(quaternion, 1)
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_comPos(self._model, data)
        mujoco.mj_camlight(self._model, data)
        return np.array([float(data.joint(name).qpos[0]) for name in talos.ACTUATED])
