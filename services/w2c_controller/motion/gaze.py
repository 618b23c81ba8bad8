"""The head looks at a point of the world while the body moves beneath it.

The head is outside the QP: its joints carry no load that matters to balance. A neck tilts (about y
of the torso), then pans (about z); the camera looks along x of the head. With tilt t and pan p the
optical axis in the torso is Ry(t) Rz(p) x = (cos t cos p, sin p, -sin t cos p).
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from w2c.messages import RobotDescription
from w2c_controller.compiled import compiled
from w2c_controller.kinematics.model import Kinematics

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

SPEED = 0.4
"""Of the head joints [rad/s]: slow enough for an operator to follow the picture."""
FARTHER = 0.22
"""How much farther ahead the robot looks once a hand leans [m]: at what came within reach."""
MARGIN = 0.02
"""To the limits of the head joints [rad]."""
SIDEWAYS = 0.05
"""Least share of a direction ahead of the torso; beyond, the neck is at its limit."""


@dataclass(frozen=True)
class Neck:
    """What is constant of a tilt-pan neck."""

    torso_joint: int
    """In Pinocchio's reduced model: the joint that moves the body the neck is on"""
    torso_from_neck: Vector
    """(3,) where both axes cross [m]"""
    bus_indices: npt.NDArray[np.intp]
    """(2,) of tilt and pan in vectors of the bus"""
    lower: Vector
    """(2,) [rad]"""
    upper: Vector


def find_neck(description: RobotDescription, reduced: pin.Model) -> Neck | None:
    """Return the neck of a robot; None for one without a tilt-pan head that carries the camera."""
    full = pin.buildModelFromXML(description.urdf, pin.JointModelFreeFlyer())
    names = [joint.name for joint in description.joints]
    if not full.existFrame(description.camera_frame):
        return None
    pan = full.frames[full.getFrameId(description.camera_frame)].parentJoint
    tilt = full.parents[pan]
    axes = (full.joints[tilt].shortname(), full.joints[pan].shortname())
    torso_name = full.names[full.parents[tilt]]
    on_the_bus = full.names[tilt] in names and full.names[pan] in names
    if axes != ("JointModelRY", "JointModelRZ") or not on_the_bus:
        return None
    rows = [full.joints[joint].idx_q for joint in (tilt, pan)]
    return Neck(
        torso_joint=reduced.getJointId(torso_name),
        torso_from_neck=np.array(full.jointPlacements[tilt].translation),
        bus_indices=np.array([names.index(full.names[joint]) for joint in (tilt, pan)]),
        lower=full.lowerPositionLimit[rows] + MARGIN,
        upper=full.upperPositionLimit[rows] - MARGIN,
    )


@compiled
def fill_neck_angles(x: float, y: float, z: float, angles: Vector) -> None:
    """Fill tilt and pan (2,) that look along a direction ahead of the torso [rad]."""
    length = math.sqrt(x * x + y * y + z * z)
    ahead = max(x / length, SIDEWAYS)
    angles[0] = math.atan2(-z / length, ahead)
    angles[1] = math.atan2(y / length, math.hypot(ahead, z / length))


@compiled
def turn_neck(
    rotation: Matrix,
    position: Vector,
    torso_from_neck: Vector,
    point: Vector,
    farther: float,
    lower: Vector,
    upper: Vector,
    step: float,
    wanted: Vector,
    angles: Vector,
) -> None:
    """Move tilt and pan (2,) by at most a step towards a point in the world, or somewhat beyond it.

    `rotation` (3, 3) and `position` (3,) are those of the torso, `wanted` (2,) is overwritten.
    """
    x, y, z = point[0] + farther - position[0], point[1] - position[1], point[2] - position[2]
    fill_neck_angles(
        rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z - torso_from_neck[0],
        rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z - torso_from_neck[1],
        rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * z - torso_from_neck[2],
        wanted,
    )
    for i in range(2):
        change = min(max(wanted[i], lower[i]), upper[i]) - angles[i]
        angles[i] += min(max(change, -step), step)


class Gaze:
    """Keeps looking at the point that the robot looked at first, or somewhat beyond it."""

    def __init__(self, neck: Neck, initial: Vector, dt: float, surface_height: float = 0.8) -> None:
        """Remember the angles to start from.

        Args:
            neck: Of the robot.
            initial: (2,) tilt and pan at the start [rad].
            dt: Period [s].
            surface_height: Of the plane that is looked at, a table's [m].
        """
        self._neck = neck
        self._angles = np.clip(initial, neck.lower, neck.upper)
        self._wanted = np.zeros(2)
        self._step = SPEED * dt
        self._height = surface_height
        self._point: Vector | None = None

    @property
    def angles(self) -> Vector:
        """Return tilt and pan (2,) now [rad]."""
        return self._angles.copy()

    def move_head(self, command: Vector, kinematics: Kinematics, *, leaning: bool) -> None:
        """Write the head's joints of this tick into a command (n,) in the order of the bus."""
        rotation, position = kinematics.joint_placement(self._neck.torso_joint)
        tilt, pan = self._neck.bus_indices
        command[tilt], command[pan] = self.step(rotation, position, leaning=leaning)

    def step(self, world_from_torso: Matrix, torso_position: Vector, *, leaning: bool) -> Vector:
        """Return tilt and pan (2,) of this tick [rad]: the array of all ticks.

        Args:
            world_from_torso: (3, 3).
            torso_position: (3,) of the torso's frame in the world [m].
            leaning: Whether a hand carries weight.
        """
        neck = self._neck
        if self._point is None:
            origin = torso_position + world_from_torso @ neck.torso_from_neck
            self._point = self._where_it_looks(world_from_torso, origin)
        turn_neck(
            world_from_torso,
            torso_position,
            neck.torso_from_neck,
            self._point,
            FARTHER if leaning else 0.0,
            neck.lower,
            neck.upper,
            self._step,
            self._wanted,
            self._angles,
        )
        return self._angles

    def _where_it_looks(self, world_from_torso: Matrix, neck: Vector) -> Vector:
        """Return the point (3,) where the axis of sight meets the plane, at most 1.5 m away."""
        tilt, pan = self._angles
        axis = world_from_torso @ np.array(
            [np.cos(tilt) * np.cos(pan), np.sin(pan), -np.sin(tilt) * np.cos(pan)]
        )
        drop = neck[2] - self._height
        distance = drop / -axis[2] if axis[2] < -0.1 and drop > 0.0 else 1.5
        return np.asarray(neck + min(distance, 1.5) * axis)
