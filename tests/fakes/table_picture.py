"""A camera above a table with a book, a cup and a plate, and the picture it takes."""

import cv2
import numpy as np

from w2c import geometry
from w2c.messages import Array, Box, Target

WIDTH, HEIGHT = 1280, 720
CAMERA = geometry.intrinsics_from_fov(WIDTH, HEIGHT, np.deg2rad(50.0))
BOOK_TOP = np.array([0.52, -0.18, 0.80])
"""Middle of the book, in the world [m]"""
TABLE_HEIGHT = 0.75


def camera_pose(yaw: float = 0.0) -> Array:
    """Return world_from_camera (4, 4) of a head that looks down, turned left by `yaw` [rad]."""
    pitch = np.deg2rad(44.0)
    forward = np.array([np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), -np.sin(pitch)])
    right = np.array([np.sin(yaw), -np.cos(yaw), 0.0])
    down = np.cross(forward, right)
    return geometry.transform(np.column_stack([right, down, forward]), [0.12, 0.0, 1.45])


def pixel_of(point: Array, world_from_camera: Array) -> tuple[float, float]:
    """Return the pixel (u, v) of a point of the world [m]."""
    return CAMERA.pixel_from_point(geometry.apply(geometry.inverse(world_from_camera), point))


def draw_table(world_from_camera: Array) -> bytes:
    """Return the JPEG of a table with a book, a cup and a plate."""
    image = np.full((HEIGHT, WIDTH, 3), (78, 84, 92), np.uint8)

    def fill(corners: list[tuple[float, float, float]], colour: tuple[int, int, int]) -> None:
        pixels = [pixel_of(np.array(corner), world_from_camera) for corner in corners]
        cv2.fillPoly(image, [np.array(pixels, np.int32)], colour, cv2.LINE_AA)

    def slab(x: float, y: float, size: tuple[float, float, float], colour: Array) -> None:
        length, width, height = size
        low, high = TABLE_HEIGHT, TABLE_HEIGHT + height
        left, right, near, far = y + width / 2, y - width / 2, x - length / 2, x + length / 2
        dark, bright = _colour(0.6 * colour), _colour(colour)
        fill([(near, left, low), (near, right, low), (near, right, high), (near, left, high)], dark)
        fill(
            [(near, left, high), (near, right, high), (far, right, high), (far, left, high)], bright
        )

    for line in np.linspace(-1.6, 1.6, 17):  # floor
        ends = [pixel_of(np.array([x, line, 0.0]), world_from_camera) for x in (0.9, 3.5)]
        start, end = ((int(u), int(v)) for u, v in ends)
        cv2.line(image, start, end, (88, 94, 102), 2, cv2.LINE_AA)
    slab(0.75, 0.0, (0.8, 1.5, 0.03), np.array([120, 158, 190]))
    slab(BOOK_TOP[0], BOOK_TOP[1], (0.2, 0.27, 0.05), np.array([96, 128, 60]))
    slab(0.78, -0.38, (0.2, 0.2, 0.035), np.array([225, 228, 230]))
    base = pixel_of(np.array([0.8, 0.2, TABLE_HEIGHT + 0.03]), world_from_camera)
    top = pixel_of(np.array([0.8, 0.2, TABLE_HEIGHT + 0.13]), world_from_camera)
    u, v, height = int(base[0]), int(base[1]), int(base[1] - top[1])
    cv2.rectangle(image, (u - 38, v - height), (u + 38, v), (52, 60, 196), -1)
    cv2.ellipse(image, (u, v), (38, 15), 0, 0, 360, (52, 60, 196), -1, cv2.LINE_AA)
    cv2.ellipse(image, (u, v - height), (38, 15), 0, 0, 360, (40, 44, 130), -1, cv2.LINE_AA)
    noise = np.random.default_rng(0).normal(0.0, 3.0, image.shape)
    image = np.clip(cv2.GaussianBlur(image, (3, 3), 0) + noise, 0, 255).astype(np.uint8)
    done, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 92])
    if not done:
        raise AssertionError("cv2 cannot encode a JPEG")
    return bytes(data.tobytes())


def _colour(values: Array) -> tuple[int, int, int]:
    blue, green, red = (int(value) for value in values)
    return blue, green, red


def make_target(
    target_id: str,
    stamp_ns: int,
    *,
    point: Array | None = BOOK_TOP,
    yaw: float = 0.0,
    corrections: int = 0,
    state: str = "proposed",
    warning: str = "",
) -> Target:
    """Return a target on the book, chosen in the picture of `stamp_ns`."""
    u, v = pixel_of(BOOK_TOP if point is None else point, camera_pose(yaw))
    corners = [BOOK_TOP + np.array([x, y, 0.0]) for x in (-0.1, 0.1) for y in (-0.135, 0.135)]
    pixels = np.array([pixel_of(corner, camera_pose(yaw)) for corner in corners])  # (4, 2)
    (left, top), (right, bottom) = pixels.min(axis=0), pixels.max(axis=0)
    return Target(
        target_id=target_id,
        frame_stamp_ns=stamp_ns,
        u=float(u),
        v=float(v),
        point=point,
        normal=None if point is None else np.array([0.0, 0.0, 1.0]),
        state=state,  # type: ignore[arg-type]
        corrections=corrections,
        instruction="Place your right hand on top of the book",
        boxes=[
            Box(
                left=float(left),
                top=float(top),
                right=float(right),
                bottom=float(bottom),
                score=1.0,
            )
        ],
        phrases=["book"],
        warning=warning,
    )
