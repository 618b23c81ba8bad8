"""The states of a goal, driven by forces that the test makes up."""

from collections.abc import Callable

import numpy as np
import pytest

from w2c.messages import Array, EndEffector, Task
from w2c_controller.events import Event
from w2c_controller.goals import Goal
from w2c_controller.hands import Hands
from w2c_controller.model import ControlledModel, Kinematics, standing_configuration
from w2c_controller.parameters import Motion, Parameters
from w2c_controller.retargeting import Retargeting
from w2c_controller.sensing import Measured
from w2c_controller.supervision import Finding
from w2c_controller.switching import Switching

DT = 0.01
IMPATIENT = Parameters(motion=Motion(load_timeout=5.0, unload_timeout=8.0))
UP = np.array([0.0, 0.0, 1.0])
TABLE = 0.84
NEAR = (0.45, -0.30, TABLE)
FAR_CUP = (1.6, 0.2, 0.9)
NEAR_CUP = (0.7, 0.3, 0.95)

Surface = Callable[["World"], float]


class World:
    """A controller's inner half, and a surface that pushes back on the right hand."""

    def __init__(self, model: ControlledModel, joints: Array, surface: Surface) -> None:
        self.retargeting = Retargeting(model, IMPATIENT, DT)
        self.retargeting.reset(joints)
        at_rest = Kinematics(model)
        at_rest.update_frames(standing_configuration(model, joints))
        self.hands = Hands(self.retargeting, at_rest)
        self.switching = Switching(self.retargeting, self.hands, DT)
        self.events: list[Event] = []
        self.findings: list[Finding] = []
        self.phases: list[str] = []
        self.enabled_at: list[float] = []
        self.left_force = np.zeros(3)
        self._surface = surface

    def run(self, seconds: float, until: str = "") -> str:
        """Run until an event, or a time. Returns the event."""
        for _ in range(round(seconds / DT)):
            was = self.retargeting.state.enabled[3]
            measured = Measured(
                feet=np.tile([0.0, 0.0, 440.0, 0.0, 0.0, 0.0], (2, 1)),
                hands=np.stack([self.left_force, self._surface(self) * UP]),
            )
            self.findings += self.switching.supervise(measured)
            new = self.switching.step(measured)
            self.events += new
            if not was and self.retargeting.state.enabled[3]:
                self.enabled_at.append(float(measured.hands[1, 2]))
            self.hands.step()
            assert self.retargeting.tick()
            if not self.phases or self.phases[-1] != self.switching.phase:
                self.phases.append(self.switching.phase)
            if any(event.state == until for event in new):
                return until
        return ""

    def states(self) -> list[str]:
        return [event.state for event in self.events]


def air(_: World) -> float:
    """No surface at all."""
    return 0.0


def table(world: World) -> float:
    """A table of 12 N/mm that the ball touches at its top; it also bears what is desired."""
    depth = TABLE + 0.05 - float(world.retargeting.kinematics.positions[3, 2])
    loaded = float(world.retargeting.state.wrenches[3, 2])
    return max(12_000.0 * depth, 0.0) + loaded


def slippery(world: World) -> float:
    """It is there until the hand leans on it."""
    return 0.0 if world.retargeting.state.enabled[3] else table(world)


def goal(
    point: tuple[float, float, float],
    hand: EndEffector = "right_hand",
    task: Task = "contact",
    goal_id: str = "g",
) -> Goal:
    radius = 0.05 if hand == "right_hand" else 0.0
    where = np.array(point)
    return Goal(
        goal_id=goal_id,
        end_effector=hand,
        task=task,
        point=where,
        normal=UP,
        target=where + radius * UP,
    )


@pytest.fixture
def make_world(model: ControlledModel, joints: Array) -> Callable[[Surface], World]:
    return lambda surface: World(model, joints, surface)


MakeWorld = Callable[[Surface], World]


def test_a_contact_is_touched_loaded_held_released_and_brought_back(make_world: MakeWorld) -> None:
    world = make_world(table)
    world.switching.place(goal(NEAR))
    assert world.run(30.0, "loaded") == "loaded"
    assert world.switching.phase == "contact"
    assert world.switching.busy_with() == ""
    assert world.retargeting.state.wrenches[3, 2] >= 9.9
    world.switching.release("r", 3)
    assert world.run(40.0, "released") == "released"
    assert world.phases == ["approach", "touch", "load", "contact", "unload", "retreat", "hold"]
    assert world.states() == ["moving", "touched", "loaded", "released"]
    assert world.events[-1].goal_id == "r"
    world.run(3.0)
    assert np.linalg.norm(world.hands.position(3) - world.hands.rest[3]) < 0.01


def test_a_contact_is_enabled_at_a_measured_force_only(make_world: MakeWorld) -> None:
    world = make_world(table)
    world.switching.place(goal(NEAR))
    world.run(30.0, "loaded")
    assert len(world.enabled_at) == 1
    assert world.enabled_at[0] > Motion().touch_force


def test_nothing_to_lean_on_is_never_a_contact(make_world: MakeWorld) -> None:
    world = make_world(air)
    world.switching.place(goal(NEAR))
    assert world.run(30.0, "aborted") == "aborted"
    assert "no surface" in world.events[-1].reason
    assert world.enabled_at == []
    world.run(12.0)
    assert world.switching.phase == "hold"


def test_an_unreachable_contact_is_given_up_with_the_gap(make_world: MakeWorld) -> None:
    world = make_world(air)
    world.switching.place(goal((1.5, -0.3, TABLE)))
    assert world.run(40.0, "aborted") == "aborted"
    assert world.states() == ["moving", "unreachable", "aborted"]
    assert world.events[1].distance > 0.2
    assert "cm short" in world.events[1].reason
    assert world.enabled_at == []


def test_a_surface_that_does_not_carry_is_left_again(make_world: MakeWorld) -> None:
    world = make_world(slippery)
    world.switching.place(goal(NEAR))
    assert world.run(40.0, "aborted") == "aborted"
    assert "did not take its load" in world.events[-1].reason
    world.run(12.0)
    assert world.switching.phase == "hold"
    assert not world.retargeting.state.enabled[3]


def test_a_reach_arrives_and_holds(make_world: MakeWorld) -> None:
    world = make_world(air)
    world.switching.place(goal(NEAR_CUP, "left_hand", "reach"))
    assert world.run(20.0, "reached") == "reached"
    assert 0 <= world.events[-1].distance < Motion().reached_distance
    world.run(2.0)
    assert world.switching.phase == "reach"
    assert world.states() == ["moving", "reached"]


def test_an_unreachable_point_is_approached_and_reported_once(make_world: MakeWorld) -> None:
    world = make_world(air)
    world.switching.place(goal(FAR_CUP, "left_hand", "reach"))
    assert world.run(40.0, "unreachable") == "unreachable"
    gap = world.events[-1].distance
    assert gap == pytest.approx(world.switching.distance())
    assert 0.2 < gap < 0.6
    world.run(5.0)
    assert world.states() == ["moving", "unreachable"]
    assert world.switching.phase == "reach"
    assert world.retargeting.failures == 0


def test_a_reaching_hand_that_touches_stops(make_world: MakeWorld) -> None:
    world = make_world(air)
    world.switching.place(goal(NEAR_CUP, "left_hand", "reach"))
    world.run(0.5)
    while world.switching.distance() > 0.05:
        world.run(DT)
    world.left_force = np.array([-15.0, 0.0, 0.0])
    world.run(6.0)
    assert world.states()[-1] == "unreachable"
    assert "in the way" in world.events[-1].reason
    assert world.switching.distance() > 0.03


def test_the_same_hand_may_be_sent_elsewhere_on_its_way(make_world: MakeWorld) -> None:
    world = make_world(air)
    world.switching.place(goal(FAR_CUP, "left_hand", "reach", "first"))
    world.run(1.0)
    assert world.switching.busy_with() == "first"
    world.switching.place(goal(NEAR_CUP, "left_hand", "reach", "second"))
    assert world.run(20.0, "reached") == "reached"
    assert world.events[-1].goal_id == "second"


def test_a_leaning_hand_unloads_before_it_goes_elsewhere(make_world: MakeWorld) -> None:
    world = make_world(table)
    world.switching.place(goal(NEAR, goal_id="first"))
    world.run(30.0, "loaded")
    world.switching.place(goal((0.5, -0.2, TABLE), goal_id="second"))
    assert world.run(60.0, "loaded") == "loaded"
    assert world.events[-1].goal_id == "second"
    assert world.phases[3:] == [
        "contact",
        "unload",
        "retreat",
        "approach",
        "touch",
        "load",
        "contact",
    ]


def test_a_support_stays_while_the_other_hand_reaches(make_world: MakeWorld) -> None:
    world = make_world(table)
    world.switching.place(goal(NEAR))
    world.run(30.0, "loaded")
    world.switching.place(goal(NEAR_CUP, "left_hand", "reach", "cup"))
    assert world.run(20.0, "reached") == "reached"
    assert world.retargeting.state.enabled == (True, True, False, True)
    assert world.retargeting.loaded(3)


def test_weight_that_cannot_be_taken_off_is_reported_and_kept(
    make_world: MakeWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = make_world(table)
    world.switching.place(goal(NEAR))
    world.run(30.0, "loaded")
    world.switching.release("r", 3)
    monkeypatch.setattr(world.retargeting, "release", lambda _: None)
    world.retargeting.keep(3)
    assert world.run(40.0, "aborted") == "aborted"
    assert "cannot be taken off" in world.events[-1].reason
    assert world.retargeting.state.enabled[3]
    assert world.switching.phase == "hold"


def test_abort_leaves_hands_where_they_are(make_world: MakeWorld) -> None:
    world = make_world(air)
    world.switching.place(goal(FAR_CUP, "left_hand", "reach"))
    world.run(3.0)
    where = world.hands.position(2)
    world.switching.abort("stopped")
    world.run(3.0)
    assert world.events[-1].state == "aborted"
    assert world.switching.phase == "hold"
    assert np.linalg.norm(world.hands.position(2) - where) < 0.03


def test_a_goal_that_is_replaced_is_told_to_have_ended(make_world: MakeWorld) -> None:
    world = make_world(air)
    world.switching.place(goal(FAR_CUP, "left_hand", "reach", "first"))
    world.run(1.0)
    world.switching.place(goal(NEAR_CUP, "left_hand", "reach", "second"))
    world.run(1.0)
    world.switching.release("third", 2)
    assert world.run(20.0, "released") == "released"
    told = [(event.goal_id, event.state) for event in world.events]
    assert told == [
        ("first", "moving"),
        ("first", "aborted"),
        ("second", "moving"),
        ("second", "aborted"),
        ("third", "released"),
    ]
    assert "second" in world.events[1].reason
