"""The inner half of a controller among surfaces that push back: no physics."""

from collections.abc import Mapping

import numpy as np

from w2c.messages import Array, EndEffector, Task
from w2c_controller.goals.goals import Goal
from w2c_controller.kinematics.model import ControlledModel, Kinematics, standing_configuration
from w2c_controller.motion.end_effectors import EndEffectors
from w2c_controller.parameters import EFFECTORS, FEET, Parameters
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.sensing.loads import Measured
from w2c_controller.switching.events import Event
from w2c_controller.switching.supervision import Finding
from w2c_controller.switching.switching import Switching

UP = np.array([0.0, 0.0, 1.0])
STIFFNESS = 12_000.0
"""Of all surfaces [N/m]."""
RADII = (0.0, 0.0, 0.0, 0.05)


class ContactWorld:
    """Contacts bear what is desired; a surface resists a free end effector that goes below it."""

    def __init__(
        self,
        model: ControlledModel,
        joints: Array,
        heights: Mapping[int, float],
        parameters: Parameters | None = None,
        dt: float = 0.01,
    ) -> None:
        """Stand.

        Args:
            model: The robot.
            joints: (nj,) [rad]
            heights: Of a level surface under each hand that has one [m].
            parameters: Of the controller.
            dt: Period [s].
        """
        self.dt = dt
        self.retargeting = Retargeting(model, parameters or Parameters(), dt)
        self.retargeting.reset(joints)
        at_rest = Kinematics(model)
        at_rest.update_frames(standing_configuration(model, joints))
        self.end_effectors = EndEffectors(self.retargeting, at_rest)
        self.switching = Switching(self.retargeting, self.end_effectors, dt)
        self.events: list[Event] = []
        self.findings: list[Finding] = []
        self.phases: list[str] = []
        self.heights = {0: 0.0, 1: 0.0, **heights}
        self.gone: set[int] = set()
        """End effectors whose surface is there no more"""
        self.hollow: set[int] = set()
        """End effectors whose surface bears nothing once it is leaned on"""
        self.touched_at: list[float] = []
        """Normal force measured when a contact was enabled, for each [N]"""
        self.extra = np.zeros((4, 3))
        """(4, 3) forces beside those of the surfaces [N]"""
        self.moved = np.zeros((4, 3))
        """(4, 3) how far each slipped, or rolled [m]"""
        self.turned = np.tile(np.eye(3), (2, 1, 1))
        """(2, 3, 3) of each hand in the world, beside the desired turns: a ball that slips on"""

    def measured(self) -> Measured:
        """Return what the robot feels."""
        state, kinematics = self.retargeting.state, self.retargeting.kinematics
        feet, hands = np.zeros((2, 6)), np.zeros((2, 3))
        for k in range(4):
            force = self.extra[k].copy()
            if k in self.heights and k not in self.gone:
                depth = self.heights[k] + RADII[k] - float(kinematics.positions[k, 2])
                resisted = max(STIFFNESS * depth, 0.0)
                bearing = 0.0 if k in self.hollow else float(state.wrenches[k, 2])
                force += (bearing if state.enabled[k] else resisted) * UP
            if k in FEET:
                feet[k, :3] = force
            else:
                hands[k - 2] = force
        return Measured(
            feet=feet,
            hands=hands,
            positions=kinematics.positions + self.moved,
            rotations=np.concatenate(
                [kinematics.rotations[:2], self.turned @ kinematics.rotations[2:]]
            ),
        )

    def run(self, seconds: float, until: str = "") -> str:
        """Run until an event, or a time. Returns the event."""
        for _ in range(round(seconds / self.dt)):
            measured, enabled = self.measured(), self.retargeting.state.enabled
            self.findings += self.switching.supervise(measured)
            new = self.switching.step(measured)
            self.events += new
            for k, was in enumerate(enabled):
                if self.retargeting.state.enabled[k] and not was:
                    self.touched_at.append(float(measured.force(k)[2]))
            self.end_effectors.step()
            assert self.retargeting.tick()
            if not self.phases or self.phases[-1] != self.switching.phase:
                self.phases.append(self.switching.phase)
            if any(event.state == until for event in new):
                return until
        return ""

    def told(self) -> list[tuple[str, str]]:
        """Return goal and state of each event."""
        return [(event.goal_id, event.state) for event in self.events]

    def states(self) -> list[str]:
        """Return the state of each event."""
        return [event.state for event in self.events]

    def normal(self, effector: int) -> float:
        """Return the desired normal force [N]."""
        return float(self.retargeting.state.wrenches[effector, 2])


def make_goal(
    point: tuple[float, float, float],
    end_effector: EndEffector = "right_hand",
    *,
    task: Task = "contact",
    goal_id: str = "g",
    force: float = 0.0,
) -> Goal:
    """Return a goal on a level surface."""
    where = np.array(point)
    return Goal(
        goal_id=goal_id,
        end_effector=end_effector,
        task=task,
        point=where,
        normal=UP,
        target=where + RADII[EFFECTORS.index(end_effector)] * UP,
        force=force,
    )
