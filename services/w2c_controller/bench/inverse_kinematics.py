"""Inverse kinematics by pin-pink on the same robot: what the whole tick is compared with.

It keeps both soles in place, moves a hand to a point, holds the centre of mass and the posture, all
as soft tasks, within joint and velocity limits, with daqp: no forces, no torques, no friction.
"""

import math
import time

import numpy as np

from w2c.extras import needs_extra
from w2c.messages import RobotDescription
from w2c_controller.bench.cases import ENDS, TURN_TICKS
from w2c_controller.kinematics.model import build_model, standing_configuration

with needs_extra("bench"):
    from pink import Configuration, solve_ik
    from pink.tasks import ComTask, FrameTask, PostureTask

SETTLE_TICKS = 200


class InverseKinematics:
    """A `Case`; see the module."""

    name = "pink.two_feet_hand.moving"

    def __init__(self, description: RobotDescription) -> None:
        controlled = build_model(description)
        model = controlled.model
        joints = description.initial_position[controlled.joint_indices]
        self._dt = description.period_ns * 1e-9
        self._configuration = Configuration(
            model, model.createData(), standing_configuration(controlled, joints)
        )
        names = [model.frames[frame].name for frame in controlled.frames]
        feet = [FrameTask(name, position_cost=1.0, orientation_cost=1.0) for name in names[:2]]
        self._hand = FrameTask(names[2], position_cost=1.0, orientation_cost=0.0)
        self._tasks = [*feet, self._hand, ComTask(cost=1.0), PostureTask(cost=1e-3)]
        for task in self._tasks:
            task.set_target_from_configuration(self._configuration)
        self._target = self._hand.transform_target_to_world.copy()
        self._tick = 0

    def prepare(self) -> None:
        """See `Case`."""
        for _ in range(SETTLE_TICKS):
            self.step()

    def step(self) -> int:
        """See `Case`."""
        share = 0.5 - 0.5 * math.cos(math.pi * self._tick / TURN_TICKS)
        self._target.translation = (1.0 - share) * ENDS[0] + share * ENDS[1]
        self._tick += 1
        begin = time.thread_time_ns()
        self._hand.set_target(self._target)
        velocity = solve_ik(self._configuration, self._tasks, self._dt, solver="daqp")
        self._configuration.integrate_inplace(np.asarray(velocity), self._dt)
        return time.thread_time_ns() - begin
