"""States of a robot that stands, for tests that need no simulator."""

from typing import Any

import numpy as np

from w2c.messages import RobotDescription, RobotState


def standing_state(description: RobotDescription, **changes: Any) -> RobotState:
    """Return the state of a robot in its initial posture, with these fields changed."""
    n = len(description.joints)
    fields: dict[str, Any] = {
        "stamp_ns": 0,
        "tick": 0,
        "position": np.array(description.initial_position),
        "velocity": np.zeros(n),
        "torque": np.zeros(n),
        "sole_wrenches": np.tile([0.0, 0.0, 440.0, 0.0, 0.0, 0.0], (2, 1)),
        "left_wrist_wrench": np.zeros(6),
        "imu_orientation": np.array([0.0, 0.0, 0.0, 1.0]),
        "imu_angular_velocity": np.zeros(3),
        "imu_linear_acceleration": np.array([0.0, 0.0, 9.81]),
        "command": np.array(description.initial_position),
        "command_tick": 0,
        "mode": "tracking",
    }
    return RobotState(**(fields | changes))
