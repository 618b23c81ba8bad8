"""Where the camera was when it took a picture, and how far joint angles that are off shift that."""

from dataclasses import dataclass

import numpy as np

from w2c.geometry import Intrinsics, Matrix, Vector, apply
from w2c.messages import Array

COVERS = 2.0
"""Times the root of the summed variances: covers at least 95 % of normal errors in 1 to 3
dimensions"""


@dataclass(frozen=True)
class CameraPose:
    """The camera and the arms in the world, by the joint angles of one instant."""

    world_from_camera: Matrix
    """(4, 4) of the optical frame"""
    arms: Array
    """(n, 2, 3) the bones of the robot's arms, in the world [m]"""
    twists: Array
    """(n, 6) how the camera moves in the world with each joint while the feet stand: velocity of
    the point at the world's origin [m/rad], then angular velocity [rad/rad]"""

    def point_jacobian(self, point: Vector) -> Array:
        """Return how a point (3,) that the camera sees moves with each joint, (3, n) [m/rad].

        v = v_origin + w x p
        """
        return np.asarray((self.twists[:, :3] + np.cross(self.twists[:, 3:], point)).T)

    def error(self, point: Vector, joint_error: float) -> float:
        """Return how far off a point (3,) may be for joint angles that are off [m].

        Args:
            point: seen by the camera, in the world [m].
            joint_error: bound of a constant error of each angle, independent of the others, of
                which nothing else is known [rad]: a standard deviation of 1 / sqrt(3) of it.
        """
        spread = float(np.linalg.norm(self.point_jacobian(point)))
        return float(COVERS * joint_error / np.sqrt(3.0) * spread)

    def pixel_speed(
        self, velocity: Array, intrinsics: Intrinsics, u: float, v: float, depth: float
    ) -> float:
        """Return how fast what stands still moves through the picture [px/s].

        Args:
            velocity: (n,) of the joints [rad/s].
            intrinsics: of the picture.
            u: where, to the right [px].
            v: down [px].
            depth: of what is there [m].
        """
        ray = intrinsics.point_from_pixel(u, v, 1.0)
        point = apply(self.world_from_camera, depth * ray)
        # The camera moves as a point fixed to it there; what stands still moves the other way.
        in_camera = self.world_from_camera[:3, :3].T @ -(self.point_jacobian(point) @ velocity)
        across = intrinsics.fx * (in_camera[0] - ray[0] * in_camera[2]) / depth
        down = intrinsics.fy * (in_camera[1] - ray[1] * in_camera[2]) / depth
        return float(np.hypot(across, down))
