"""Contacts of the simulated robot: a foot off the ground, a table that goes, a hand that slips.

Friction, elasticity and impacts are those of the physics; the controller is told of none of it.
"""

import numpy as np
import pytest

from w2c.messages import Array, PlaceGoal, ReleaseGoal
from w2c_controller.controller import Controller
from w2c_controller.parameters import LEFT_FOOT, RIGHT_HAND
from w2c_evaluation.closed_loop import ClosedLoop
from w2c_sim_robot.description import make_description
from w2c_sim_robot.perturbation import Perturbation
from w2c_sim_robot.study import Block, study_robot

PERIOD_S = 0.002
TABLE = Block((0.55, -0.25, 0.80), (0.15, 0.15, 0.02))
POINT = np.array([0.48, -0.27, 0.82])
WALL = Block((0.68, -0.25, 1.10), (0.05, 0.40, 0.40))
POINT_ON_WALL = np.array([0.63, -0.20, 1.15])
UP = np.array([0.0, 0.0, 1.0])
BACK = np.array([-1.0, 0.0, 0.0])
SLIPPERY = 0.3 / 0.8
"""Of the simulated friction of the hand: 0.3 where the controller assumes 0.6."""


class Leaning:
    """A robot whose right hand leans on a table or a wall."""

    def __init__(self, *, wall: bool = False, friction: float = 1.0, force: float = 0.0) -> None:
        description = make_description(lock_step=True)
        self.robot = study_robot(
            Perturbation(ball_friction=friction),
            (WALL if wall else TABLE,),
            description=description,
        )
        self.controller = Controller(description)
        self.loop = ClosedLoop(self.robot, self.controller)
        self.run(0.5)
        if wall:
            self.place("lean", "right_hand", POINT_ON_WALL, force, BACK)
        else:
            self.place("lean", "right_hand", POINT, force)
        assert self.run(30.0, "loaded") == "loaded"

    def run(self, seconds: float, until: str = "") -> str:
        """Run for a time, until a state of a goal or a fall."""
        return self.loop.run(
            round(seconds / PERIOD_S), until=(until,), watch=lambda: self.robot.fell
        )

    def place(
        self, goal_id: str, end_effector: str, point: Array, force: float = 0.0, normal: Array = UP
    ) -> None:
        goal = PlaceGoal(
            goal_id=goal_id,
            end_effector=end_effector,  # type: ignore[arg-type]
            task="contact",
            point=point,
            normal=normal,
            force=force,
        )
        assert self.loop.ask(goal) == ""

    def causes(self) -> list[tuple[str, str, int]]:
        """Return cause, subject and tick of each hazard that began since the last call."""
        return [
            (report.hazard.cause, report.hazard.subject, report.tick)
            for report in self.controller.take_safety_reports()
            if report.begins
        ]

    def hand(self) -> Array:
        """Return where the right hand really is (3,) [m]."""
        return np.array(self.robot.truth().end_effector_positions[RIGHT_HAND])


@pytest.mark.slow
def test_a_foot_is_lifted_and_put_down_again_while_a_hand_leans_on_a_wall() -> None:
    leaning = Leaning(wall=True, force=40.0)
    leaning.run(1.0)
    refusal = leaning.loop.ask(ReleaseGoal(goal_id="lift", end_effector="left_foot"))
    assert refusal == ""
    hand = []
    while leaning.loop.events[-1].state != "released":
        leaning.run(PERIOD_S)
        hand.append(-leaning.robot.truth().contact_forces[RIGHT_HAND, 0])
        assert leaning.robot.tick < 30_000
    assert min(hand) > 25.0
    assert max(hand) < 55.0
    truth = leaning.robot.truth()
    assert truth.end_effector_positions[LEFT_FOOT, 2] > 0.03
    assert truth.contact_forces[LEFT_FOOT, 2] == 0.0
    refusal = leaning.loop.ask(ReleaseGoal(goal_id="jump", end_effector="right_foot"))
    assert "only foot on the ground" in refusal
    leaning.place("step", "left_foot", np.array([0.03, 0.10, 0.0]))
    assert leaning.run(15.0, "loaded") == "loaded"
    truth = leaning.robot.truth()
    assert truth.contact_forces[LEFT_FOOT, 2] > 60.0
    stepped = truth.end_effector_positions[LEFT_FOOT]
    np.testing.assert_allclose(stepped, [0.03, 0.10, 0.0], atol=0.01)
    assert not leaning.robot.fell
    assert leaning.causes() == []
    assert leaning.controller.retargeting.failures == 0


@pytest.mark.slow
def test_a_robot_whose_table_goes_stands_on_its_feet() -> None:
    leaning = Leaning(force=100.0)
    leaning.run(0.5)
    assert leaning.controller.retargeting.state.wrenches[RIGHT_HAND, 2] > 95.0
    assert leaning.causes() == []
    gone = leaning.robot.tick
    leaning.robot.model.geom_pos[leaning.robot.model.geom("block_0").id, 2] -= 0.6
    leaning.run(1.0)
    found = leaning.causes()
    assert [(cause, subject) for cause, subject, _ in found] == [("contact_lost", "right_hand")]
    assert (found[0][2] - gone) * PERIOD_S < 0.15
    assert leaning.loop.events[-1].state == "aborted"
    assert "lost its support" in leaning.loop.events[-1].reason
    assert leaning.controller.retargeting.state.enabled == (True, True, False, False)
    leaning.run(4.0)
    assert not leaning.robot.fell
    assert leaning.controller.retargeting.failures == 0


@pytest.mark.slow
def test_a_hand_that_slips_is_found_within_a_fifth_of_a_second_and_the_robot_holds() -> None:
    leaning = Leaning(friction=SLIPPERY)
    leaning.run(2.0)
    assert leaning.causes() == []
    where, begun = leaning.hand(), 0
    leaning.robot.push(np.array([-70.0, 0.0, 0.0]), 2.0, "arm_right_4_link")
    found: list[tuple[str, str, int]] = []
    while not found and not leaning.robot.fell and leaning.robot.tick < 20_000:
        leaning.run(PERIOD_S)
        if not begun and np.linalg.norm(leaning.hand() - where) > 0.002:
            begun = leaning.robot.tick
        found = leaning.causes()
    assert found[0][:2] == ("contact_slips", "right_hand")
    assert (leaning.robot.tick - begun) * PERIOD_S < 0.2
    leaning.run(3.0)
    assert not leaning.robot.fell
    assert leaning.controller.phase in ("hold", "unload")
