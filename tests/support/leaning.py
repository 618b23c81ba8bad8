"""The paper's scenario (a), robot and controller in one process, without bus, words or pictures.

Asked at once, the cup is out of reach and the robot stays balanced; leaning on the book, it is
reached.
"""

from dataclasses import dataclass, field

import numpy as np

from w2c.messages import (
    Array,
    EndEffector,
    PlaceGoal,
    ReleaseGoal,
    RobotDescription,
    Task,
)
from w2c.messages.robot import DriverMode
from w2c_controller.controller import Controller
from w2c_controller.motion.grasp import REACH_STANDOFF
from w2c_controller.preview.reach import farthest_reach
from w2c_controller.switching.events import Event
from w2c_sim_robot.description import make_description
from w2c_sim_robot.model import build_model
from w2c_sim_robot.physics import Simulator
from w2c_sim_robot.scenes.scenario_a import scenario_a
from w2c_sim_robot.scenes.scene import Scene

UP = np.array([0.0, 0.0, 1.0])
PERIOD_S = 0.002
FARTHEST_CUP = 1.21
"""The cup stands on the table [m]."""


@dataclass
class Outcome:
    """What one layout showed."""

    scene: Scene
    band: tuple[float, float]
    """Where the cup could stand: reach on two feet + 5 cm, reach with the book - 2 cm [m]"""
    first: str = ""
    """Last event of the reach on two feet"""
    gap_on_two_feet: float = -1.0
    """From where the hand should come, truth [m]"""
    lean: str = ""
    hand_force: float = 0.0
    """Of the right hand when the left has reached, truth [N]"""
    second: str = ""
    gap_leaning: float = -1.0
    """Truth [m]"""
    fell: bool = False
    ticks: int = 0
    solver_failures: int = 0
    foot_drift: float = 0.0
    """Truth [m]"""
    events: list[Event] = field(default_factory=list)

    @property
    def succeeded(self) -> bool:
        """Whether it went as in the paper."""
        return (
            self.first == "unreachable"
            and self.lean == "loaded"
            and self.second == "reached"
            and self.hand_force > 15.0
            and self.gap_leaning <= 0.03
            and not self.fell
        )


class ClosedLoop:
    """A simulator and a controller that answer each other."""

    def __init__(self, description: RobotDescription, scene: Scene | None) -> None:
        self.simulator = Simulator(build_model(scene, visuals=False), description)
        self.controller = Controller(description)
        self.events: list[Event] = []
        self._command_tick = -1

    def run(self, seconds: float, until: tuple[str, ...] = ()) -> str:
        """Run; returns the event that ended it, "" at the end of time or after a fall."""
        for _ in range(round(seconds / PERIOD_S)):
            mode: DriverMode = "tracking" if self._command_tick >= 0 else "holding"
            state = self.simulator.state(command_tick=self._command_tick, mode=mode)
            command = self.controller.tick(state)
            self._command_tick = command.tick
            self.simulator.step(command.position)
            new = self.controller.take_events()
            self.events += new
            for event in new:
                if event.state in until:
                    return event.state
            if self.simulator.fell:
                return ""
        return ""

    def gap(self, hand: int, point: Array) -> float:
        """Return the true distance between a hand's frame and a point [m]."""
        return float(np.linalg.norm(self.simulator.truth().end_effector_positions[hand] - point))


def place(goal_id: str, hand: EndEffector, task: Task, point: Array) -> PlaceGoal:
    """Return a goal on an upward surface."""
    return PlaceGoal(goal_id=goal_id, end_effector=hand, task=task, point=point, normal=UP)


def draw_scene(
    description: RobotDescription, rng: np.random.Generator
) -> tuple[Scene, tuple[float, float]]:
    """Return a layout and the band its cup was drawn from; an empty band is drawn again."""
    while True:
        book = (float(rng.uniform(0.42, 0.52)), float(rng.uniform(-0.30, -0.20)))
        across = float(rng.uniform(0.05, 0.25))
        scene = scenario_a(book_xy=book)
        height = scene.object("cup").top_in_world[2]
        top = np.array(scene.object("book").top_in_world)
        support = place("support", "right_hand", "contact", top)
        reaches = [
            farthest_reach(
                description,
                end_effector="left_hand",
                origin=(0.0, across),
                height=height,
                direction=(1.0, 0.0),
                support=leaning,
            )
            for leaning in (None, support)
        ]
        near, far = reaches[0] + 0.05, min(reaches[1] - 0.02, FARTHEST_CUP)
        if near < far:
            scene = scenario_a(
                book_xy=book,
                cup_xy=(float(rng.uniform(near, far)), across),
                book_yaw=float(rng.uniform(-0.3, 0.3)),
                cup_yaw=float(rng.uniform(-np.pi, np.pi)),
            )
            return scene, (near, far)


def lean_and_reach(seed: int) -> Outcome:
    """Play one random layout."""
    description = make_description(lock_step=True)
    scene, band = draw_scene(description, np.random.default_rng(seed))
    loop = ClosedLoop(description, scene)
    outcome = Outcome(scene=scene, band=band)
    book = np.array(scene.object("book").top_in_world)
    cup = np.array(scene.object("cup").top_in_world)
    at_cup = cup + REACH_STANDOFF * UP
    requests = loop.controller.requests
    loop.run(2.5)
    requests.place(place("too far", "left_hand", "reach", cup))
    outcome.first = loop.run(40.0, ("reached", "unreachable", "aborted"))
    outcome.gap_on_two_feet = loop.gap(2, at_cup)
    requests.release(ReleaseGoal(goal_id="back", end_effector="left_hand"))
    loop.run(30.0, ("released",))
    requests.place(place("lean", "right_hand", "contact", book))
    outcome.lean = loop.run(40.0, ("loaded", "aborted"))
    if outcome.lean == "loaded":
        requests.place(place("cup", "left_hand", "reach", cup))
        outcome.second = loop.run(40.0, ("reached", "unreachable", "aborted"))
        loop.run(1.0)
        outcome.gap_leaning = loop.gap(2, at_cup)
        truth = loop.simulator.truth()
        outcome.hand_force = float(np.linalg.norm(truth.contact_forces[3]))
        feet = np.array([[0.0, 0.085, 0.0], [0.0, -0.085, 0.0]])
        moved = truth.end_effector_positions[:2] - feet
        outcome.foot_drift = float(np.abs(moved).max())
    outcome.fell = loop.simulator.fell
    outcome.ticks = loop.simulator.tick
    outcome.solver_failures = loop.controller.retargeting.failures
    outcome.events = loop.events
    return outcome
