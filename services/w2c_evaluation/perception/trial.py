"""One scene: a picture as sensors measure it, pixels lifted from it, and how far off they are."""

import time
from typing import Any

import msgspec
import numpy as np

from w2c.depth import DEPTH_UNIT, decode_depth, encode_depth, unpack_depth
from w2c.errors import RefusedError
from w2c.geometry import apply, inverse
from w2c.library import library
from w2c.messages import Array
from w2c_evaluation.perception.sensors import SensorErrors

FIRST_SCENE = 900_000
"""Scenes from this seed on are for judging only"""
FOOTPRINT = 0.03
"""Radius of what shall touch the surface [m]"""
SAME_SURFACE = 0.03
"""An answer farther off is on another surface [m]"""
KNOWN_WITHIN = 2
"""Pixels around the asked one in which its own surface must have depth to be known"""


class PixelResult(msgspec.Struct, frozen=True, kw_only=True):
    """One pixel: what was there, what was answered."""

    u: float
    v: float
    name: str
    """Of the thing there"""
    support: str
    """How it carries, `room` for floor and walls"""
    depth: float
    """True z-depth [m]"""
    known: bool
    """Whether the sensor gave depth of that surface within two pixels"""
    refusal: str = ""
    """Why there is no answer"""
    camera_error: float = -1.0
    """Of the point, in the camera frame [m]; -1 without an answer, as below"""
    camera_bound: float = -1.0
    """What the answer said of it [m]"""
    world_error: float = -1.0
    """[m]"""
    world_bound: float = -1.0
    """[m]"""
    normal_error: float = -1.0
    """[rad]"""
    milliseconds: float = -1.0
    """CPU time of the thread for the first question about a picture, unpacking of the depth
    included"""
    milliseconds_again: float = -1.0
    """... for a later one: unpacked depth is kept"""
    warning: str = ""


class SceneResult(msgspec.Struct, frozen=True, kw_only=True):
    """What became of the pixels of one scene."""

    scene: int
    pixels: list[PixelResult]


def run_scene(scene: int, count: int, pictures: str, errors: SensorErrors) -> SceneResult:
    """Lift `count` random pixels of the picture of a scene, as its sensors measure it.

    Args:
        scene: Seed of the scene.
        count: Pixels.
        pictures: Directory that keeps exact pictures; empty = nothing is kept.
        errors: Of the sensors.
    """
    kept = library("kept_survey")
    truth = kept(scene, count, pictures) if pictures else library("survey")(scene, count)
    rng = np.random.default_rng([scene, 33])
    encoded = encode_depth(errors.depth(truth.depth, rng))
    judge = Judge(truth, encoded, errors.position(truth.position, rng), errors.encoder_bias)
    return SceneResult(scene=scene, pixels=judge.judge())


class Judge:
    """Compares what perception says of one picture with the truth."""

    def __init__(self, truth: Any, encoded: bytes, position: Array, joint_error: float) -> None:
        """Take a picture.

        Args:
            truth: The survey.
            encoded: Its depth as the camera sends it.
            position: (n,) measured joint angles [rad].
            joint_error: How far off an angle may be, as the operator of the robot knows [rad].
        """
        self._truth, self._encoded = truth, encoded
        self._position, self._joint_error = position, joint_error
        self._lift = library("lift")
        self._kinematics = library("camera_kinematics")(library("make_description")())
        self._seen = self._kinematics.camera_pose(position)

    def judge(self) -> list[PixelResult]:
        """Return what became of each pixel."""
        self._answer(0.5 * self._truth.depth.shape[1], 0.5 * self._truth.depth.shape[0])  # warm
        return [self._pixel(index) for index in range(len(self._truth.pixels))]

    def _pixel(self, index: int) -> PixelResult:
        truth = self._truth
        u, v = (float(value) for value in truth.pixels[index])
        point = truth.points[index]
        there = PixelResult(
            u=u,
            v=v,
            name=truth.names[index],
            support=truth.supports[index],
            depth=float(point[2]),
            known=self._known(u, v, point),
        )
        surface, first, later = self._answer(u, v)
        there = msgspec.structs.replace(there, milliseconds=first, milliseconds_again=later)
        if isinstance(surface, str):
            return msgspec.structs.replace(there, refusal=surface)
        answered = apply(inverse(self._seen.world_from_camera), surface.point)
        normal = self._seen.world_from_camera[:3, :3].T @ surface.normal
        pose_error = self._seen.error(surface.point, self._joint_error)
        return msgspec.structs.replace(
            there,
            camera_error=_distance(answered, point),
            camera_bound=surface.error_bound,
            world_error=_distance(surface.point, apply(truth.world_from_camera, point)),
            world_bound=surface.error_bound + pose_error,
            normal_error=float(np.arccos(np.clip(normal @ truth.normals[index], -1.0, 1.0))),
            warning=surface.warning,
        )

    def _answer(self, u: float, v: float) -> tuple[Any, float, float]:
        """Return the surface, or the reason of the refusal, and what it takes [ms].

        The first question about a picture unpacks its depth, a later one does not.
        """
        truth = self._truth
        height, width = truth.depth.shape
        started = time.thread_time()
        depth = unpack_depth(self._encoded, width, height)
        unpacked = time.thread_time()
        try:
            answer: Any = self._lift(
                depth,
                truth.intrinsics,
                self._seen.world_from_camera,
                u,
                v,
                footprint=FOOTPRINT,
                depth_unit=DEPTH_UNIT,
            )
        except RefusedError as error:
            answer = str(error)
        ended = time.thread_time()
        return answer, 1e3 * (ended - started), 1e3 * (ended - unpacked)

    def _known(self, u: float, v: float, point: Array) -> bool:
        """Tell whether the sensor gave depth of the surface behind a pixel."""
        if not np.isfinite(point).all():
            return False
        truth = self._truth
        height, width = truth.depth.shape
        depth = decode_depth(self._encoded, width, height)
        row, column = int(v), int(u)
        rows = slice(max(0, row - KNOWN_WITHIN), row + KNOWN_WITHIN + 1)
        columns = slice(max(0, column - KNOWN_WITHIN), column + KNOWN_WITHIN + 1)
        near = np.abs(truth.depth[rows, columns] - point[2]) < SAME_SURFACE
        return bool((near & (depth[rows, columns] > 0.0)).any())


def _distance(a: Array, b: Array) -> float:
    return float(np.linalg.norm(a - b))
