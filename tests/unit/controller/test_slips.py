"""What counts as a slip, contact by contact, on readings that are made up."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from w2c.messages import Array
from w2c_controller.parameters import LEFT_FOOT, LEFT_HAND, RIGHT_FOOT, RIGHT_HAND
from w2c_controller.switching.contact_parameters import Supervision
from w2c_controller.switching.supervision import ContactWatch, Finding

DT = 0.01
LIMITS = Supervision()
FRICTION = 0.6
RADIUS = 0.05
"""Of the right hand's ball [m]."""
UP = np.array([0.0, 0.0, 1.0])


class Robot:
    """Stands on both feet, and leans on its right hand with 60 N."""

    def __init__(self) -> None:
        self.watch = ContactWatch(LIMITS, FRICTION, (0.0, RADIUS), DT)
        self.wanted = np.array([400.0, 400.0, 0.0, 60.0])
        self.forces = self.wanted[:, None] * UP
        self.normals = np.tile(UP, (4, 1))
        self.tares = np.zeros((4, 3))
        self.positions = np.array(
            [[0.0, 0.1, 0.0], [0.0, -0.1, 0.0], [0.5, 0.3, 1.0], [0.5, -0.3, 1]]
        )
        self.rotations = np.tile(np.eye(3), (4, 1, 1))
        for effector in (LEFT_FOOT, RIGHT_FOOT, RIGHT_HAND):
            self.watch.set(effector, True)

    def run(
        self,
        seconds: float,
        effector: int = RIGHT_HAND,
        velocity: float = 0.0,
        turn: Array | None = None,
    ) -> list[Finding]:
        """Move along x, or by a turn (3, 3) a step; return what is found."""
        found = []
        for _ in range(round(seconds / DT)):
            self.positions[effector, 0] += velocity * DT
            if turn is not None:
                self.rotations[effector] = turn @ self.rotations[effector]
            new = self.look()
            found += [] if new is None else [new]
        return found

    def look(self) -> Finding | None:
        """Take one measurement."""
        wrenches = np.zeros((4, 6))
        wrenches[:, 2] = self.wanted
        feet = np.zeros((2, 6))
        feet[:, :3] = self.forces[:2]
        state = SimpleNamespace(wrenches=wrenches, target_rotations=self.rotations)
        feelers = SimpleNamespace(normals=self.normals, tares=self.tares)
        measured = SimpleNamespace(
            feet=feet, hands=self.forces[2:], positions=self.positions, rotations=self.rotations
        )
        return self.watch.step(cast(Any, state), cast(Any, feelers), cast(Any, measured))


@pytest.fixture
def robot() -> Robot:
    robot = Robot()
    assert robot.run(0.5) == []
    return robot


def turn_about_y(angle: float) -> Array:
    """Return a rotation (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


@pytest.mark.parametrize("lifted", [(), (LEFT_FOOT,), (RIGHT_FOOT,)])
def test_a_hand_slips_after_the_same_way_on_one_foot_and_on_two(
    robot: Robot, lifted: tuple[int, ...]
) -> None:
    robot.forces[RIGHT_HAND, 1] = 50.0  # at the edge of the cone: creep does not count
    for foot in lifted:
        robot.watch.set(foot, False)
    robot.run(0.1)
    (found,) = robot.run(0.14, velocity=0.05)
    assert (found.cause, found.effector) == ("contact_slips", RIGHT_HAND)
    assert LIMITS.slip_distance[1] < found.value < LIMITS.slip_distance[1] + 0.0005


def test_without_a_foot_on_the_ground_nothing_is_a_slip(robot: Robot) -> None:
    robot.watch.set(LEFT_FOOT, False)
    robot.watch.set(RIGHT_FOOT, False)
    assert robot.run(0.5, velocity=0.05) == []


def test_a_hand_of_which_little_is_wanted_takes_hold_where_it_is(robot: Robot) -> None:
    robot.wanted[RIGHT_HAND] = LIMITS.slip_load - 1.0
    assert robot.run(0.5, velocity=0.05) == []
    robot.wanted[RIGHT_HAND] = 60.0
    assert robot.run(0.5) == []


def test_a_hand_that_lets_go_for_a_moment_takes_hold_where_it_is(robot: Robot) -> None:
    robot.forces[RIGHT_HAND] = (LIMITS.lost_measured[1] - 1.0) * UP
    assert robot.run(0.05, velocity=0.2) == []
    robot.forces[RIGHT_HAND] = 60.0 * UP
    assert robot.run(0.5) == []


def test_motion_before_a_hand_let_go_is_forgotten(robot: Robot) -> None:
    bearing = np.array([0.0, 50.0, 60.0])  # at the edge of the cone: creep does not count
    robot.forces[RIGHT_HAND] = bearing
    assert robot.run(0.08, velocity=0.05) == []
    robot.forces[RIGHT_HAND] = 0.0
    assert robot.run(0.02) == []
    robot.forces[RIGHT_HAND] = bearing
    assert robot.run(0.08, velocity=0.05) == []


def test_a_foot_that_turns_in_the_air_does_not_make_the_ball_slip(robot: Robot) -> None:
    robot.watch.set(RIGHT_FOOT, False)
    robot.run(0.1)
    assert robot.run(2.0, RIGHT_FOOT, velocity=0.1, turn=turn_about_y(0.005)) == []


@pytest.mark.parametrize("wall", [False, True])
def test_a_ball_that_rolls_does_not_slip_on_a_table_nor_up_a_wall(robot: Robot, wall: bool) -> None:
    if wall:
        robot.normals[RIGHT_HAND] = [-1.0, 0.0, 0.0]
        robot.forces[RIGHT_HAND] = [-60.0, 0.0, 0.0]
    way = np.cross([0.0, 1.0, 0.0], RADIUS * robot.normals[RIGHT_HAND])
    angle, found = 0.005, []
    for _ in range(200):
        robot.positions[RIGHT_HAND] += angle * way
        found += robot.run(DT, turn=turn_about_y(angle))
    assert found == []


@pytest.mark.parametrize(("along", "slips"), [(20.0, True), (35.0, False)])
def test_slow_motion_is_a_slip_only_well_within_the_assumed_cone(
    robot: Robot, along: float, slips: bool
) -> None:
    assert 20.0 < LIMITS.creep_cone * FRICTION * 60.0 < 35.0
    robot.forces[RIGHT_HAND, 1] = along
    found = robot.run(5.0, velocity=0.002)
    assert bool(found) == slips


def test_the_cone_is_that_of_the_force_beside_what_the_free_hand_read(robot: Robot) -> None:
    robot.tares[RIGHT_HAND] = [0.0, 30.0, -60.0]
    robot.forces[RIGHT_HAND] = [0.0, 30.0, 0.0]
    assert robot.run(5.0, velocity=0.002)


def test_creep_that_goes_on_is_told_again_and_a_slip_once(robot: Robot) -> None:
    assert len(robot.run(1.0, velocity=0.05)) == 1
    assert robot.run(2.0) == []
    assert len(robot.run(1.0, velocity=0.05)) == 1
    assert robot.run(20.0) == []
    found = robot.run(8.0, velocity=0.002)
    assert len(found) >= 2


def test_slow_motion_long_ago_is_forgotten(robot: Robot) -> None:
    for _ in range(5):
        assert robot.run(1.0, velocity=0.002) == []
        assert robot.run(4.0 * LIMITS.creep_window) == []


def test_fast_motion_long_ago_is_forgotten(robot: Robot) -> None:
    robot.forces[RIGHT_HAND, 1] = 50.0  # at the edge of the cone: creep does not count
    for _ in range(5):
        assert robot.run(0.1, velocity=0.05) == []
        assert robot.run(4.0 * LIMITS.slip_window) == []


def test_a_hand_that_carries_nothing_is_no_trouble_of_slips(robot: Robot) -> None:
    robot.watch.set(LEFT_HAND, True)
    robot.wanted[LEFT_HAND] = 15.0  # too little to be missed, and to be watched for slips
    assert robot.run(1.0, LEFT_HAND, velocity=0.05) == []


@pytest.mark.parametrize("lighter", [LEFT_FOOT, RIGHT_FOOT])
def test_of_two_feet_the_lighter_one_slips(robot: Robot, lighter: int) -> None:
    robot.forces[lighter] = 100.0 * UP
    (found,) = robot.run(0.14, RIGHT_FOOT, velocity=0.05)
    assert found.effector == lighter


def test_a_foot_that_carries_nothing_does_not_slip(robot: Robot) -> None:
    robot.wanted[RIGHT_FOOT] = LIMITS.lost_desired[0] - 10.0
    robot.forces[RIGHT_FOOT] = (LIMITS.lost_measured[0] - 1.0) * UP
    assert robot.run(0.5, RIGHT_FOOT, velocity=0.05) == []


def test_while_the_feet_move_the_slow_motion_of_a_hand_begins_anew(robot: Robot) -> None:
    assert robot.run(1.0, velocity=0.002) == []
    robot.forces[RIGHT_FOOT] = 350.0 * UP
    found = robot.run(0.5, LEFT_FOOT, velocity=-0.05)
    assert {finding.effector for finding in found} == {RIGHT_FOOT}  # the lighter one
    assert robot.run(5.0 * LIMITS.slip_window) == []
    assert robot.run(1.0, velocity=0.002) == []


def test_a_reading_that_is_no_number_moves_nothing(robot: Robot) -> None:
    robot.positions[RIGHT_HAND, 0] = np.nan
    assert robot.run(0.1) == []
    robot.positions[RIGHT_HAND, 0] = 0.5
    assert robot.run(0.5) == []
    assert len(robot.run(0.3, velocity=0.05)) == 1
