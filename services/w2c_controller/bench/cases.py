"""The cases of `w2c bench control`: contact sets, at rest, in motion, and at the end of the reach.

Each is a `Controller` of its own, whose whole tick is timed: guards, sensing, switching, filters,
Retargeting, force control, gaze, and the command that is sent.
"""

import time
from typing import Literal, Protocol

import numpy as np

from w2c.errors import ControlError
from w2c.messages import PlaceGoal, RobotDescription
from w2c_controller.bench.parts import Parts
from w2c_controller.bench.robot import MeantRobot
from w2c_controller.controller import Controller
from w2c_controller.parameters import EFFECTORS, LEFT_HAND, RIGHT_HAND

UP = np.array([0.0, 0.0, 1.0])
SUPPORT = np.array([0.45, -0.3, 0.9])
"""Where the right hand leans, on a table [m]."""
ENDS = (np.array([0.5, 0.35, 1.05]), np.array([0.55, 0.1, 0.95]))
"""Between which the left hand moves [m]."""
BEYOND = np.array([1.4, 0.3, 0.9])
"""What the left hand cannot reach [m]."""
TURN_TICKS = 600
"""Between two targets of the hand that moves: it never rests."""
SETTLE_TICKS = 2500
PATIENCE = 30_000
"""Most ticks until a contact bears weight, or the end of the reach is told."""

Motion = Literal["static", "moving", "stalled"]


class Case(Protocol):
    """Something that is timed tick by tick."""

    name: str

    def prepare(self) -> None:
        """Come to where timing begins. Raises ControlError."""

    def step(self) -> int:
        """Do one tick. Returns the thread's CPU time that it took [ns]."""


class ControlCase:
    """The controller on two feet, or on two feet and the right hand; the left hand moves."""

    def __init__(
        self, description: RobotDescription, *, support: bool, motion: Motion, seed: int
    ) -> None:
        self.name = f"{'two_feet_hand' if support else 'two_feet'}.{motion}"
        self.controller = Controller(description)
        self._robot = MeantRobot(self.controller, seed)
        self._support = support
        self._motion = motion
        self._goals = 0
        self._prepared = False

    def prepare(self) -> None:
        """See `Case`."""
        for _ in range(SETTLE_TICKS):
            self.step()
        if self._support:
            self._robot.surfaces[RIGHT_HAND] = SUPPORT[2] + self.controller.model.hand_radius[1]
            self._ask(RIGHT_HAND, "contact", SUPPORT)
            self._await("loaded")
        if self._motion == "stalled":
            self._ask(LEFT_HAND, "reach", BEYOND)
            self._await("unreachable")
        self._prepared = True

    def step(self) -> int:
        """See `Case`."""
        moves = self._prepared and self._motion == "moving"
        if moves and self._robot.tick % TURN_TICKS == 0:
            self._ask(LEFT_HAND, "reach", ENDS[self._goals % 2])
        state = self._robot.state()
        begin = time.thread_time_ns()
        command = self.controller.tick(state)
        taken = time.thread_time_ns() - begin
        self._robot.follow(command.position)
        return taken

    def time_parts(self, ticks: int) -> dict[str, list[int]]:
        """Return the CPU time of each part of some ticks [ns]."""
        parts = Parts(self.controller)
        for _ in range(ticks):
            parts.end_tick(self.step())
        return parts.samples

    def _ask(self, effector: int, task: Literal["contact", "reach"], point: np.ndarray) -> None:
        self._goals += 1
        self.controller.requests.place(
            PlaceGoal(
                goal_id=f"bench-{self._goals}",
                end_effector=EFFECTORS[effector],
                task=task,
                point=point,
                normal=UP,
            )
        )

    def _await(self, state: str) -> None:
        told = []
        for _ in range(PATIENCE):
            self.step()
            for event in self.controller.take_events():
                if event.state == state:
                    return
                told.append(f"{event.state} {event.reason}".strip())
        raise ControlError(
            f"case {self.name}: no event '{state}' within {PATIENCE} ticks, only: "
            f"{', '.join(told) or 'none'}; {self.controller.snapshot().message or 'no hold'}"
        )


def control_cases(description: RobotDescription, seed: int) -> list[ControlCase]:
    """Return all cases of the controller."""
    motions: tuple[Motion, ...] = ("static", "moving", "stalled")
    return [
        ControlCase(description, support=support, motion=motion, seed=seed)
        for support in (False, True)
        for motion in motions
    ]
