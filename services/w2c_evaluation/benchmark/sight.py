"""What a rendered picture shows, with the point of the world behind every pixel."""

from dataclasses import dataclass
from typing import Any

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from w2c.geometry import rotation_from_quaternion

BoxEdges = tuple[int, int, int, int]
Mask = npt.NDArray[np.bool_]
ROBOT = 255
HINTED_SHARE = 0.00003
"""Of the picture: what shows less is not seen by anybody (28 pixels of 1280 x 720)"""
LEAST_SEEN = 0.55
"""Of the outline of a thing that is spoken of. The outline is that of its box: a round thing, or
one that lies askew, fills less of it"""
CLEAR_SHARE = 0.0012
"""What shows less is not spoken of (1106 pixels of 1280 x 720)"""


class Thing(msgspec.Struct, frozen=True):
    """An object of a truth file of `w2c scenes render`, as far as the benchmark uses it."""

    id: int
    name: str
    kind: str
    colour: str
    material: str
    names: tuple[str, ...]
    """The usual word first"""
    phrases: tuple[str, ...]
    """All that fit it"""
    own_phrases: tuple[str, ...]
    """Those that fit nothing else in the scene"""
    held_out: bool
    held_out_kind: bool
    held_out_material: bool
    box: BoxEdges | None
    """Around what is visible of it; None where it is hidden"""
    visible_pixels: int
    position: tuple[float, float, float]
    orientation: tuple[float, float, float, float]
    size: tuple[float, float, float]
    movable: bool
    support: str

    @property
    def edges(self) -> BoxEdges:
        """Return the box of a thing that is seen. Raises ValueError for a hidden one."""
        if self.box is None:
            raise ValueError(f"{self.name} is not seen")
        return self.box

    @property
    def never_trained_on(self) -> bool:
        """Whether pictures for training never show such a thing."""
        return self.held_out or self.held_out_kind or self.held_out_material

    @property
    def corners(self) -> npt.NDArray[np.float64]:
        """Return the corners (8, 3) of its box in the world [m]."""
        x, y, z = self.size
        local = [(a * x, b * y, c * z) for a in (-0.5, 0.5) for b in (-0.5, 0.5) for c in (0.0, 1)]
        rotation = rotation_from_quaternion(self.orientation)
        return np.asarray(np.asarray(local) @ rotation.T + np.asarray(self.position))

    @property
    def foot(self) -> float:
        """Return the height of its underside [m]."""
        return float(self.corners[:, 2].min())

    @property
    def top(self) -> float:
        """Return the height of its highest point [m]."""
        return float(self.corners[:, 2].max())

    @property
    def upright(self) -> bool:
        """Whether it stands as it was built."""
        x, y, _, _ = self.orientation
        return bool(np.hypot(x, y) < 0.05)


class _Truth(msgspec.Struct, frozen=True):
    """A truth file, as far as the benchmark uses it."""

    intrinsics: tuple[float, float, float, float]
    world_from_camera: list[list[float]]
    objects: tuple[Thing, ...]


@dataclass(frozen=True)
class Sight:
    """One picture."""

    rgb: npt.NDArray[np.uint8]
    """(h, w, 3)"""
    identity: npt.NDArray[np.uint8]
    """(h, w): 0 = room, n = thing with id n, 255 = robot"""
    world: npt.NDArray[np.float32]
    """(h, w, 3) point of the world behind each pixel [m]; NaN where it is not known"""
    things: tuple[Thing, ...]
    intrinsics: tuple[float, float, float, float]
    """fx, fy, cx, cy [px]"""
    world_from_camera: npt.NDArray[np.float64]
    """(4, 4) of the optical frame"""

    @property
    def pixels(self) -> int:
        """Return the area of the picture [px]."""
        return self.identity.size

    def seen(self) -> tuple[Thing, ...]:
        """Return what somebody may see, furniture too: what a phrase might mean."""
        return tuple(t for t in self.things if t.visible_pixels >= HINTED_SHARE * self.pixels)

    def clear(self) -> tuple[Thing, ...]:
        """Return the things that can be moved and are clearly to be seen."""
        least = CLEAR_SHARE * self.pixels
        return tuple(t for t in self.things if t.movable and t.visible_pixels >= least)

    def cut_off(self, thing: Thing) -> bool:
        """Whether a thing reaches out of the picture, so that nobody knows where it ends."""
        left, top, right, bottom = thing.edges
        height, width = self.identity.shape
        return left <= 0 or top <= 0 or right >= width or bottom >= height

    def hidden(self, thing: Thing) -> bool:
        """Whether what is seen of a thing says little of where it is: others are in front."""
        fx, fy, cx, cy = self.intrinsics
        in_camera = (thing.corners - self.world_from_camera[:3, 3]) @ self.world_from_camera[:3, :3]
        u = fx * in_camera[:, 0] / in_camera[:, 2] + cx
        v = fy * in_camera[:, 1] / in_camera[:, 2] + cy
        left, top, right, bottom = thing.edges
        return bool((right - left) * (bottom - top) < LEAST_SEEN * np.ptp(u) * np.ptp(v))

    def pixels_per_cm(self, thing: Thing) -> float:
        """Return how long a centimetre looks where a thing is."""
        middle = thing.corners.mean(axis=0) - self.world_from_camera[:3, 3]
        return 0.01 * self.intrinsics[0] / float(middle @ self.world_from_camera[:3, 2])

    def free_surface(self, height_m: float, tolerance_m: float = 0.015) -> Mask:
        """Return where the level surface of a height is seen, with nothing on it (h, w)."""
        level = np.abs(self.world[:, :, 2] - height_m) < tolerance_m
        fixed = [thing.id for thing in self.things if not thing.movable]
        return np.asarray(level & np.isin(self.identity, [0, *fixed]), dtype=np.bool_)


def sight_of(picture: Any) -> Sight:
    """Return what a picture of the simulator shows (`w2c_sim_robot.scenes.true_pictures`)."""
    truth = msgspec.convert(picture.truth, _Truth)
    return Sight(
        picture.rgb,
        picture.identity,
        world_points(picture.depth, truth.intrinsics, np.asarray(truth.world_from_camera)),
        truth.objects,
        truth.intrinsics,
        np.asarray(truth.world_from_camera),
    )


def world_points(
    depth: npt.NDArray[np.float32],
    intrinsics: tuple[float, float, float, float],
    world_from_camera: npt.NDArray[np.float64],
) -> npt.NDArray[np.float32]:
    """Return the points (h, w, 3) of the world that pixels of z-depth (h, w) show [m]."""
    fx, fy, cx, cy = intrinsics
    height, width = depth.shape
    across = (np.arange(width, dtype=np.float32) + 0.5 - cx) / fx
    along = (np.arange(height, dtype=np.float32) + 0.5 - cy) / fy
    rays = np.empty((height, width, 3), np.float32)
    rays[:, :, 0], rays[:, :, 1], rays[:, :, 2] = across, along[:, None], 1.0
    known = np.where(depth > 0.0, depth, np.nan)[:, :, None]
    rotation = world_from_camera[:3, :3].astype(np.float32)
    points = (rays * known) @ rotation.T + world_from_camera[:3, 3].astype(np.float32)
    return np.asarray(points, dtype=np.float32)


def footprint_distance(thing: Thing, points: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return how far points (n, 3) are from the footprint of a thing, seen from above [m]."""
    (x, y), (width, depth), angle = cv2.minAreaRect(thing.corners[:, :2].astype(np.float32))
    turn = np.radians(angle)
    along = np.array([np.cos(turn), np.sin(turn)], np.float32)
    across = np.array([-along[1], along[0]], np.float32)
    away = points[:, :2] - np.array([x, y], np.float32)
    outside = np.stack([np.abs(away @ along) - width / 2, np.abs(away @ across) - depth / 2])
    return np.asarray(np.hypot(*np.maximum(outside, 0.0)), dtype=np.float32)
