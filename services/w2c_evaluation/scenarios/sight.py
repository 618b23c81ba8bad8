"""What the operator sees: the picture with the shown point, and the wanted place as a circle.

The circle lies on the surface, so it is an ellipse in the picture, and its size tells how long a
centimetre is there. Nothing else of the world is known to the operator.
"""

from dataclasses import dataclass
from math import hypot

import numpy as np

from w2c.geometry import Intrinsics, Matrix, Vector, apply, frame_from_normal, inverse

Pixel = tuple[float, float]

ACCEPTED_M = 0.02
"""Radius of the circle: a point inside it is confirmed. A centimetre less than what counts as
reached, for what camera, perception and controller add."""
ACCEPTED_PX = 8.0
"""A point this near the wanted one is confirmed in any case: nobody sees less, and the smallest
step that words can ask for (10 px) would hardly bring it nearer."""


@dataclass(frozen=True)
class Circle:
    """The wanted place in a picture."""

    centre: Pixel
    metres_from_pixels: Matrix
    """(2, 2): from the centre, to places on the surface [m/px]; exact in its middle"""
    pixels_per_cm: float
    """Of lengths across the picture"""

    def holds(self, pixel: Pixel) -> bool:
        """Tell whether a point of the picture is accepted."""
        offset = np.subtract(pixel, self.centre)
        on_surface = self.metres_from_pixels @ offset
        return bool(np.linalg.norm(on_surface) <= ACCEPTED_M) or hypot(*offset) <= ACCEPTED_PX


@dataclass(frozen=True)
class Sight:
    """One look at the picture."""

    shown: Pixel
    wanted: Circle

    @property
    def error(self) -> Pixel:
        """From the shown point to the wanted one (du, dv) [px]."""
        return self.wanted.centre[0] - self.shown[0], self.wanted.centre[1] - self.shown[1]

    @property
    def pixels_per_cm(self) -> float:
        """Length of a centimetre at the wanted place, across the picture [px]."""
        return self.wanted.pixels_per_cm

    @property
    def good(self) -> bool:
        """Tell whether the point is where it is wanted."""
        return self.wanted.holds(self.shown)


def draw_circle(
    point: Vector, normal: Vector, world_from_camera: Matrix, intrinsics: Intrinsics
) -> Circle:
    """Return a place (3,) on a surface with this normal (3,), as a camera sees it.

    Raises:
        GeometryError: the place is behind the camera.
    """
    camera_from_world = inverse(world_from_camera)
    in_camera = apply(camera_from_world, point)
    tangents = frame_from_normal(normal)[:, :2]  # (3, 2), in the world
    across = camera_from_world[:3, :3] @ tangents
    x, y, z = in_camera
    # How the pixel moves with the point in the camera's frame (2, 3): the pinhole, differentiated.
    jacobian = np.array(
        [
            [intrinsics.fx / z, 0.0, -intrinsics.fx * x / z**2],
            [0.0, intrinsics.fy / z, -intrinsics.fy * y / z**2],
        ]
    )
    return Circle(
        intrinsics.pixel_from_point(in_camera),
        # A surface seen edge-on has no inverse: then only ACCEPTED_PX counts.
        np.asarray(np.linalg.inv(jacobian @ across + 1e-6 * np.eye(2)), np.float64),
        0.01 * intrinsics.fx / float(z),
    )
