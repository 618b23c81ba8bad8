"""How far a hand gets, found by running the Retargeting ahead of time to its stall.

Used for laying out scenes, and for previews. Nothing here shares data with the controller's own
model.
"""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from w2c.errors import ControlError
from w2c.geometry import frame_from_normal, unit
from w2c.messages import PlaceGoal, RobotDescription
from w2c_controller.desired import DesiredState
from w2c_controller.goals import check_end_effector, check_place
from w2c_controller.grasp import approach_direction, pointing_rotation
from w2c_controller.model import ControlledModel, build_model
from w2c_controller.parameters import Parameters
from w2c_controller.program import clamp_norm
from w2c_controller.retargeting import Retargeting
from w2c_controller.stall import StallDetector

Vector = npt.NDArray[np.float64]

STEP = 0.01
"""Period of the look-ahead [s]: five times the controller's; limits are the controller's."""
HASTE = 4.0
"""How much faster forces may change than on the robot: only the time to the stall depends on it."""
LEAD = 0.03
"""How far the target runs ahead of the hand [m]."""
ON_TARGET = 0.01
"""A hand this close follows [m]."""
PATIENCE = 4000
"""Longest look-ahead [ticks]."""
SWEEP_SPEED = 0.15
"""[m/s]"""


class LookAhead:
    """A Retargeting of its own, with coarse steps."""

    def __init__(self, model: ControlledModel, parameters: Parameters | None = None) -> None:
        self._parameters = parameters or Parameters()
        limits = self._parameters.limits
        hasty = replace(
            self._parameters,
            limits=replace(
                limits,
                foot_force_rate=HASTE * limits.foot_force_rate,
                foot_torque_rate=HASTE * limits.foot_torque_rate,
                hand_force_rate=HASTE * limits.hand_force_rate,
            ),
        )
        self._model = model
        self._retargeting = Retargeting(model, hasty, STEP)

    @property
    def hand_radius(self) -> tuple[float, float]:
        """Of the hands, left and right [m]."""
        return self._model.hand_radius

    def start(self, joints: Vector) -> None:
        """Stand on both feet with these joint angles (nj,) [rad]."""
        self._retargeting.reset(joints)

    def start_from(self, state: DesiredState) -> None:
        """Go on from a copy of a desired state."""
        self._retargeting.adopt(state)

    def move(self, hand: int, target: Vector) -> float:
        """Bring a hand to a point (3,), or as close as it gets. Returns the distance left [m]."""
        self._free(hand)
        stall = StallDetector(self._parameters.motion, STEP)
        distance = self._distance(hand, target)
        for _ in range(PATIENCE):
            self._pull(hand, target)
            distance = self._distance(hand, target)
            settled = stall.step(self._retargeting.kinematics.positions[hand])
            if settled:
                break
        return distance

    def lean(self, hand: int, target: Vector, normal: Vector) -> None:
        """Bring a hand to a support and load it.

        Raises:
            ControlError: it cannot be reached, or takes no load.
        """
        distance = self.move(hand, target)
        if distance > self._parameters.motion.reached_distance:
            raise ControlError(
                f"the support at {np.round(target, 3).tolist()} cannot be reached: "
                f"{distance:.3f} m are left"
            )
        self._retargeting.enable(hand, frame_from_normal(normal))
        for _ in range(PATIENCE):
            if self._retargeting.loaded(hand):
                return
            self._retargeting.tick()
        raise ControlError("the support takes no load")

    def point(self, hand: int, target: Vector, normal: Vector) -> None:
        """Turn a hand as it would be turned to reach for a point (3,) with this normal (3,)."""
        rotation = pointing_rotation(approach_direction(target, normal))
        self._retargeting.state.target_rotations[hand] = rotation

    def sweep(self, hand: int, origin: Vector, direction: Vector) -> float:
        """Follow a ray until balance or the arm ends it. Returns the distance along it [m].

        Args:
            hand: Index of the hand.
            origin: (3,) of the ray [m].
            direction: (3,) unit.
        """
        start = self._retargeting.kinematics.positions[hand]
        along = max(float((start - origin) @ direction), 0.0)
        self.move(hand, origin + along * direction)
        farthest, waited = 0.0, 0.0
        while waited < self._parameters.motion.stall_time:
            target = origin + along * direction
            self._pull(hand, target)
            if self._distance(hand, target) < ON_TARGET:
                farthest, waited = along, 0.0
                along += SWEEP_SPEED * STEP
            else:
                waited += STEP
        return farthest

    def _pull(self, hand: int, target: Vector) -> None:
        position = self._retargeting.kinematics.positions[hand]
        lead = clamp_norm(target - position, LEAD)
        self._retargeting.state.target_positions[hand] = position + lead
        self._retargeting.tick()
        self._retargeting.kinematics.update_frames(self._retargeting.state.q)

    def _distance(self, hand: int, target: Vector) -> float:
        return float(np.linalg.norm(self._retargeting.kinematics.positions[hand] - target))

    def _free(self, hand: int) -> None:
        """Take a hand off its support first, as the controller would."""
        self._retargeting.release(hand)
        for _ in range(PATIENCE):
            if not self._retargeting.state.enabled[hand]:
                return
            self._retargeting.tick()
        raise ControlError("the hand's weight cannot be taken off its support")


def farthest_reach(
    description: RobotDescription,
    *,
    end_effector: str,
    origin: tuple[float, float],
    height: float,
    direction: tuple[float, float],
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0),
    support: PlaceGoal | None = None,
) -> float:
    """Return how far a hand's frame gets along a horizontal ray, from the initial posture [m].

    Args:
        description: The robot.
        end_effector: left_hand or right_hand.
        origin: x, y of the ray's origin, in the world [m].
        height: Of the ray [m].
        direction: x, y of the ray; any length.
        normal: Of the surface that is reached for: the hand points into it.
        support: Where the other hand leans; None: on two feet.

    Raises:
        GoalRefusedError: a hand or a support that no controller would take.
        ControlError: the support cannot be leaned on.
    """
    hand = check_end_effector(end_effector)
    model = build_model(description)
    ahead = LookAhead(model)
    ahead.start(description.initial_position[model.joint_indices])
    if support is not None:
        goal = check_place(support, model.hand_radius)
        ahead.lean(goal.effector, goal.target, goal.normal)
    ray = unit([direction[0], direction[1], 0.0])
    start = np.array([origin[0], origin[1], height])
    ahead.point(hand, start + ray, unit(normal))
    return ahead.sweep(hand, start, ray)


def preview_distance(ahead: LookAhead, state: DesiredState, goal: PlaceGoal) -> float:
    """Return what a goal would leave between hand and point [m], going on from a desired state.

    Raises:
        GoalRefusedError: no controller would take the goal.
    """
    checked = check_place(goal, ahead.hand_radius)
    ahead.start_from(state)
    if checked.task == "reach":
        ahead.point(checked.effector, checked.target, checked.normal)
    return ahead.move(checked.effector, checked.target)
