"""Plans the way of a goal before it is admitted: a blocked one is refused, and nothing moves."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from w2c.errors import GoalRefusedError
from w2c.messages import HeightField
from w2c_controller.goals.goals import Goal, pointed
from w2c_controller.kinematics.model import ControlledModel, Kinematics
from w2c_controller.motion.grasp import STEEPER
from w2c_controller.motion.routes import UP, check_retreat, plan_approach
from w2c_controller.motion.terrain import Arm, make_terrain
from w2c_controller.parameters import HANDS, Motion

Vector = npt.NDArray[np.float64]

SHOULDER, ELBOW = 1, 3
"""Joints of an arm: where its axes cross, and where it bends"""


class RoutePlanner:
    """Knows both arms; for the threads of calls, one at a time, never for the loop."""

    def __init__(self, controlled: ControlledModel, at_rest: Kinematics, motion: Motion) -> None:
        """Look at the posture that hands return to.

        Args:
            controlled: The robot.
            at_rest: Of that posture.
            motion: Clearances and speeds.
        """
        self._motion = motion
        self._hand_radius = controlled.hand_radius
        self._kinematics = Kinematics(controlled)
        self._arms = {}
        self._rest = {}
        for k in HANDS:
            joints = controlled.joints_of(k) - 6 + 2  # universe and base come first
            _, shoulder = at_rest.joint_placement(int(joints[SHOULDER]))
            _, elbow = at_rest.joint_placement(int(joints[ELBOW]))
            radius = max(controlled.hand_radius[k - HANDS[0]], motion.arm_radius)
            self._arms[k] = Arm(radius, elbow, shoulder, motion.reach_of_ways)
            self._rest[k] = at_rest.positions[k].copy()

    def plan(self, goal: Goal, field: HeightField, posture: Vector, *, leaves: bool) -> Goal:
        """Return the goal with the terrain of its way.

        A hand that reaches points down more where something stands before its point.

        Args:
            goal: That was checked.
            field: What the camera saw.
            posture: (nq,) desired now.
            leaves: Whether the end effector leaves a support first.

        Raises:
            GoalRefusedError: the way there or back is blocked; says by what.
        """
        k = goal.effector
        if k not in HANDS:
            return goal
        terrain = make_terrain(
            field,
            self._arms[k],
            goal.point,
            goal.normal,
            self._motion.clearance,
            reach=goal.task == "reach",
        )
        self._kinematics.update_frames(posture)
        start = self._kinematics.positions[k].copy()
        if leaves:
            start = start + self._motion.retreat_height * UP
        if goal.task != "reach":
            return self._planned(replace(goal, terrain=terrain), start)
        blocked, tried = None, None
        for steeper in STEEPER:
            turned = pointed(goal, self._hand_radius[k - HANDS[0]], steeper)
            if tried is not None and (turned.fingers == tried).all():
                continue
            tried = turned.fingers
            try:
                over = replace(terrain, behind=-tried)
                return self._planned(replace(turned, terrain=over), start)
            except GoalRefusedError as error:
                blocked = blocked or error
        raise blocked or GoalRefusedError("no way of the hand was tried")

    def _planned(self, goal: Goal, start: Vector) -> Goal:
        """Return a goal with the bow of its way. Raises GoalRefusedError."""
        planned = plan_approach(goal, start, self._motion)
        check_retreat(planned, self._rest[goal.effector], self._motion)
        return planned
