"""What is known of Talos beside its geometry: joints, stiffness, efforts, and how it stands."""

import numpy as np

from w2c.messages import Array

LEG = tuple(f"leg_{{side}}_{i}_joint" for i in range(1, 7))
LEFT_LEG = tuple(name.format(side="left") for name in LEG)
RIGHT_LEG = tuple(name.format(side="right") for name in LEG)
TORSO = ("torso_1_joint", "torso_2_joint")
LEFT_ARM = tuple(f"arm_left_{i}_joint" for i in range(1, 8))
# The right forearm ends in a ball: its wrist joints do not exist.
RIGHT_ARM = tuple(f"arm_right_{i}_joint" for i in range(1, 5))
HEAD = ("head_1_joint", "head_2_joint")

ACTUATED = LEFT_LEG + RIGHT_LEG + TORSO + LEFT_ARM + RIGHT_ARM + HEAD
"""The 27 joints in the order of every joint vector on the bus; the head is not in the QP."""

SOLE_FRAMES = ("left_sole_link", "right_sole_link")
HAND_FRAMES = ("left_hand_frame", "right_hand_frame")
WRIST_SENSOR_LINK = "wrist_left_ft_link"
IMU_LINK = "imu_link"
CAMERA_FRAME = "rgbd_rgb_optical_frame"
BASE_LINK = "base_link"

SOLE_HALF_SIZE = (0.10, 0.065)
"""Half length and half width of the flat part of a foot [m]."""
BALL_RADIUS = 0.05
"""Of the right hand [m]."""
BALL_MASS = 2.0
"""[kg]"""
BALL_OFFSET = (0.0, 0.0, -0.10)
"""Centre of the ball in arm_right_5_link [m]; (-0.02, 0, -0.3643) in arm_right_4_link."""
LEFT_HAND_OFFSET = (0.0, 0.0, -0.2425)
"""left_hand_frame in arm_left_7_link, between the fingertips [m]."""

_ARM_STIFFNESS = (10000.0, 10000.0, 5000.0, 10000.0, 3000.0, 3000.0, 3000.0)
_ARM_EFFORT = (100.0, 100.0, 70.0, 70.0, 20.0, 8.0, 8.0)
_LEG_EFFORT = (100.0, 160.0, 160.0, 400.0, 160.0, 100.0)

STIFFNESS: dict[str, float] = {
    **dict.fromkeys(LEFT_LEG + RIGHT_LEG, 5000.0),
    **dict.fromkeys(TORSO, 10000.0),
    **dict(zip(LEFT_ARM, _ARM_STIFFNESS, strict=True)),
    **dict(zip(RIGHT_ARM, _ARM_STIFFNESS[:4], strict=True)),
    **dict.fromkeys(HEAD, 300.0),
}
"""Of the flexible position control, torque over angle error [Nm/rad]."""

EFFORT: dict[str, float] = {
    **dict(zip(LEFT_LEG, _LEG_EFFORT, strict=True)),
    **dict(zip(RIGHT_LEG, _LEG_EFFORT, strict=True)),
    **dict.fromkeys(TORSO, 200.0),
    **dict(zip(LEFT_ARM, _ARM_EFFORT, strict=True)),
    **dict(zip(RIGHT_ARM, _ARM_EFFORT[:4], strict=True)),
    "head_1_joint": 8.0,
    "head_2_joint": 4.0,
}
"""Limits [Nm] of a Talos whose arms may lean: they carry 245 N, those of the wheel 105 N."""

# Knees bent, and the centre of mass above the middle of the soles (1 cm behind it).
_LEG_STANDING = (0.0, 0.0, -0.475, 0.86, -0.385, 0.0)

READY: dict[str, float] = {
    **dict(zip(LEFT_LEG, _LEG_STANDING, strict=True)),
    **dict(zip(RIGHT_LEG, _LEG_STANDING, strict=True)),
    "torso_1_joint": 0.0,
    "torso_2_joint": 0.12,
    # Elbows out and bent, hands beside the body and above table height: out of the camera's view,
    # and a hand that sets out does not have to come from under the table.
    **dict(zip(LEFT_ARM, (0.25, 0.64, -0.45, -1.65, 0.0, 0.0, 0.0), strict=True)),
    **dict(zip(RIGHT_ARM, (-0.25, -0.64, 0.5, -1.6), strict=True)),
    # With the torso, the camera looks 50 degrees down: it sees a table from 0.42 to 1.2 m ahead.
    "head_1_joint": 0.75,
    "head_2_joint": 0.0,
}
"""Joint angles at the start [rad]."""


def ready_position() -> Array:
    """Return the joint angles at the start, (27,) in the order of `ACTUATED` [rad]."""
    return np.array([READY[name] for name in ACTUATED])
