"""A few ticks of a controller that commands nothing: what is compiled is compiled before it counts.

Without it the first tick with a robot takes seconds where the cache of compiled code is cold.
"""

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from w2c.bus.codec import decode_message, encode_message
from w2c.messages import HeightField, PlaceGoal, RobotDescription, RobotState
from w2c_controller.controller import Controller
from w2c_controller.kinematics.model import ControlledModel, standing_configuration
from w2c_controller.parameters import RIGHT_HAND

Vector = npt.NDArray[np.float64]

TICKS = 12
REACH = (0.5, 0.3, 1.0)
"""A point that moves a hand [m]."""


def rehearse(description: RobotDescription) -> None:
    """Let a controller of its own stand, begin to reach, begin anew on the way, and lean."""
    controller = Controller(description)
    torque = _weight(controller.model, np.array(description.initial_position))
    for tick in range(TICKS):
        # As it comes from the bus: what is compiled depends on whether arrays may be written.
        payload = encode_message(_standing(description, tick, torque))
        controller.tick(decode_message(payload, RobotState))
        if tick in (TICKS // 2, TICKS // 2 + 2):
            controller.requests.place(_goal(f"rehearsal {tick}"))
        if tick == TICKS - 3:
            controller.retargeting.enable(RIGHT_HAND, np.eye(3))


def _goal(goal_id: str) -> PlaceGoal:
    """Return a goal over something low."""
    low = HeightField(
        stamp_ns=0, origin=(0.4, 0.2), cell=0.02, heights=np.full((4, 4), 0.2, np.float32)
    )
    return PlaceGoal(
        goal_id=goal_id,
        end_effector="left_hand",
        task="reach",
        point=np.array(REACH),
        normal=np.array([0.0, 0.0, 1.0]),
        obstacles=low,
    )


def _weight(model: ControlledModel, posture: Vector) -> Vector:
    """Return the torques (n,) by which the limbs of a robot in the air bear themselves [Nm]."""
    q = standing_configuration(model, posture[model.joint_indices])
    torque = np.zeros(posture.shape[0])
    gravity = pin.computeGeneralizedGravity(model.model, model.model.createData(), q)
    torque[model.joint_indices] = gravity[6:]
    return torque


def _standing(description: RobotDescription, tick: int, torque: Vector) -> RobotState:
    """Return the state of a robot in its initial posture, with these torques (n,) [Nm]."""
    posture = np.array(description.initial_position)
    return RobotState(
        stamp_ns=tick * description.period_ns,
        tick=tick,
        position=posture,
        velocity=np.zeros(posture.shape[0]),
        torque=torque,
        sole_wrenches=np.zeros((2, 6)),
        left_wrist_wrench=np.zeros(6),
        imu_orientation=np.array([0.0, 0.0, 0.0, 1.0]),
        imu_angular_velocity=np.zeros(3),
        imu_linear_acceleration=np.zeros(3),
        command=posture,
        command_tick=tick - 1,
        mode="tracking",
    )
