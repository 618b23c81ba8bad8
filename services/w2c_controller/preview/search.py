"""Where a hand can be at rest, found by a few large steps instead of running time ahead.

The Retargeting integrates one QP a tick until it stalls. Its stall is a stationary point of

    min over q, lambda   sum of the pose, posture, torque and wrench costs
    s.t. fixed contacts, static equilibrium, joint, torque and friction limits,

which does not depend on the period. One QP with a period of 1 s, without limits on the rates of
wrenches and with the velocity limits as a trust region, is a Gauss-Newton step of sequential
quadratic programming on that problem: some twenty of them do what takes the robot ten seconds.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from w2c_controller.kinematics.model import ControlledModel, Kinematics
from w2c_controller.parameters import FEET, Parameters
from w2c_controller.seiko.desired import DesiredState
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.switching.blocking import limits_reached

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

STEP = 1.0
"""Period of one step [s]: it makes rates and increments the same numbers."""
UNLIMITED = 1e4
"""Of wrench rates and of the corrections of drift: a step may remove all of it."""


@dataclass(frozen=True)
class Stage:
    """How large the steps are."""

    trust: float
    """Largest joint step as a share of the joint's velocity limit times a second."""
    pull: float
    """The farthest that one step asks of the hand [m]."""
    torque_share: float
    """Of the torque limits. Large steps stay below them, because what a step overshoots for the
    curvature of the torques is not thrown back."""
    steps: int
    """At most"""
    settled: float
    """A hand that moves less in a step has arrived or is at its limit [m]."""
    damping: float
    """Weight of the joint increments: what would swing to and fro about a limit settles."""


COARSE = Stage(trust=0.05, pull=0.15, torque_share=0.95, steps=20, settled=1e-2, damping=10.0)
FINE = Stage(trust=0.02, pull=0.03, torque_share=1.0, steps=40, settled=3e-4, damping=300.0)
"""The pull is the lead of the controller's own filter: a hand that cannot reach is drawn by the
same force, and so stalls at the same place."""
STILL_STEPS = 2
"""Steps in a row without motion that end a stage."""
UNLOADED = 0.5
"""A hand that bears less can be taken off [N]."""

RESIDUAL_FORCE = 1.0
"""A posture whose equilibrium is off by more does not stand [N, Nm]."""
DRIFT = 1e-3
"""A contact that had to move by more does not hold [m]."""


class StaticSearch:
    """Moves a copy of a desired state to where it would be at rest. Not thread-safe."""

    def __init__(self, controlled: ControlledModel, parameters: Parameters | None = None) -> None:
        self.controlled = controlled
        self.parameters = parameters or Parameters()
        self._stages = [
            (stage, Retargeting(controlled, _stepping(self.parameters, stage), STEP))
            for stage in (COARSE, FINE)
        ]
        self._current = self._stages[-1][1]

    @property
    def state(self) -> DesiredState:
        """Return the state found; it belongs to the search."""
        return self._current.state

    @property
    def kinematics(self) -> Kinematics:
        """Return the kinematics and statics of that state."""
        return self._current.kinematics

    def start(self, joints: Vector) -> None:
        """Stand on both feet with these joint angles (nj,) [rad]. Raises ControlError."""
        self._current.reset(joints)

    def start_from(self, state: DesiredState) -> None:
        """Go on from a copy of a desired state."""
        self._current.adopt(state)

    def position(self, hand: int) -> Vector:
        """Return where a hand is (3,), a copy [m]."""
        return np.array(self._current.kinematics.positions[hand])

    def move(self, hand: int, target: Vector) -> float:
        """Bring a free hand to a point (3,), or as close as it gets. Returns what is left [m]."""
        for stage, retargeting in self._stages:
            self._hand_over(retargeting)
            self._settle(stage, hand, target)
        return float(np.linalg.norm(self.position(hand) - target))

    def free(self, hand: int) -> bool:
        """Take a hand off its support, as the controller would. Returns whether that is possible.

        The hand stays where it is; only its force goes.
        """
        if not self.state.enabled[hand]:
            return True
        stage, retargeting = self._stages[-1]
        self._hand_over(retargeting)
        retargeting.release(hand)
        for _ in range(stage.steps):
            retargeting.tick()
            if not retargeting.state.enabled[hand]:
                break
        retargeting.keep(hand)
        self._settle(stage, hand, self.position(hand))
        return not retargeting.state.enabled[hand] and self.stands()

    def load(self, hand: int, contact_rotation: Matrix) -> float:
        """Make a hand a support where it is. Returns the normal force that it takes [N].

        Args:
            hand: Index of the hand.
            contact_rotation: (3, 3) world_from_contact, z out of the surface.
        """
        stage, retargeting = self._stages[-1]
        self._hand_over(retargeting)
        retargeting.enable(hand, contact_rotation)
        still, before = 0, 0.0
        for _ in range(stage.steps):
            retargeting.tick()
            force = float(retargeting.state.wrenches[hand, 2])
            still = still + 1 if abs(force - before) < UNLOADED else 0
            before = force
            if still >= STILL_STEPS:
                break
        return before if self.stands() else 0.0

    def stands(self) -> bool:
        """Return whether the state found is an equilibrium on contacts that did not move."""
        state, kinematics = self.state, self.kinematics
        kinematics.update_statics(
            state.q, state.wrenches, state.contact_rotations, state.enabled, state.levers
        )
        moved = [
            float(np.linalg.norm(kinematics.positions[k] - state.target_positions[k]))
            for k in range(4)
            if state.enabled[k]
        ]
        residual = float(np.abs(kinematics.static[:6]).max())
        return residual < RESIDUAL_FORCE and max(moved, default=0.0) < DRIFT

    def lead(self) -> float:
        """Return how far the centre of mass is ahead of the middle of the soles that stand [m]."""
        state, kinematics = self.state, self.kinematics
        feet = [k for k in FEET if state.enabled[k]]
        middle = kinematics.positions[feet].mean(axis=0)
        ahead = kinematics.rotations[feet][:, :2, 0].mean(axis=0)
        offset = (kinematics.center_of_mass(state.q) - middle)[:2]
        return float(offset @ ahead / np.linalg.norm(ahead))

    def limits_reached(self) -> list[str]:
        """Return the limits that the state found is at, in words."""
        return limits_reached(self._current)

    def _hand_over(self, retargeting: Retargeting) -> None:
        """Go on with another stage from the same state."""
        if retargeting is not self._current:
            retargeting.adopt(self._current.state)
            self._current = retargeting

    def _settle(self, stage: Stage, hand: int, target: Vector) -> None:
        """Step until the hand moves no more; steps without a solution do not move it."""
        retargeting, still = self._current, 0
        retargeting.state.target_positions[hand] = target
        for _ in range(stage.steps):
            before = self.position(hand)
            retargeting.tick()
            retargeting.kinematics.update_frames(retargeting.state.q)
            moved = float(np.linalg.norm(self.position(hand) - before))
            still = still + 1 if moved < stage.settled else 0
            if still >= STILL_STEPS or self._overshoots(stage):
                return

    def _overshoots(self, stage: Stage) -> bool:
        """Return whether large steps brought a torque beyond its limit."""
        limit = self.parameters.limits.torque_fraction * self.controlled.effort
        return stage is COARSE and bool((np.abs(self.state.torque) > limit).any())


def _stepping(parameters: Parameters, stage: Stage) -> Parameters:
    """Return parameters that make a tick of one second a step of the search."""
    limits = parameters.limits
    return replace(
        parameters,
        weights=replace(parameters.weights, joint_velocity=stage.damping),
        limits=replace(
            limits,
            velocity_fraction=stage.trust,
            balance_velocity_fraction=stage.trust,
            torque_fraction=stage.torque_share * limits.torque_fraction,
            foot_force_rate=UNLIMITED,
            foot_torque_rate=UNLIMITED,
            hand_force_rate=UNLIMITED,
        ),
        clamps=replace(
            parameters.clamps,
            position=stage.pull,
            bias_force=UNLIMITED,
            bias_torque=UNLIMITED,
            bias_position=UNLIMITED,
            bias_rotation=UNLIMITED,
        ),
    )
