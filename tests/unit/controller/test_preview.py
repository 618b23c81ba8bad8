"""A preview says what would happen, and why, without changing what it looks at."""

from dataclasses import replace

import numpy as np
import pytest

from support.stalling import random_target, stall_distance
from w2c.geometry import frame_from_normal
from w2c.messages import Array, EndEffector, PlaceGoal, PreviewReply, Task
from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import RIGHT_HAND, Parameters
from w2c_controller.preview.preview import preview
from w2c_controller.preview.search import StaticSearch
from w2c_controller.seiko.desired import DesiredState

UP = (0.0, 0.0, 1.0)
BOOK = np.array([0.48, -0.25, 0.84])
REACHED = Parameters().motion.reached_distance


@pytest.fixture
def standing(search: StaticSearch, joints: Array) -> DesiredState:
    search.start(joints)
    return search.state.copy()


@pytest.fixture
def leaning(search: StaticSearch, joints: Array) -> DesiredState:
    """The right hand on a book."""
    search.start(joints)
    search.move(RIGHT_HAND, BOOK + 0.05 * np.array(UP))
    search.load(RIGHT_HAND, np.eye(3))
    return search.state.copy()


def _ask(
    search: StaticSearch,
    state: DesiredState,
    end_effector: EndEffector,
    task: Task,
    point: object,
    normal: tuple[float, float, float] = UP,
) -> PreviewReply:
    goal = PlaceGoal(
        goal_id="p",
        end_effector=end_effector,
        task=task,
        point=np.array(point, dtype=np.float64),
        normal=np.array(normal),
    )
    return preview(search, state, goal)


def _agreement(
    search: StaticSearch, model: ControlledModel, joints: Array, seed: int, count: int
) -> tuple[list[bool], list[float]]:
    """Return whether preview and Retargeting agree, and by how much their distances differ [m]."""
    rng = np.random.default_rng(seed)
    same, differences = [], []
    for _ in range(count):
        hand, target = random_target(rng)
        search.start(joints)
        found = search.move(hand, target)
        left = stall_distance(model, joints, hand, target, dt=0.01)
        same.append((found <= REACHED) == (left <= REACHED))
        differences.append(abs(found - left))
    return same, differences


def test_the_search_ends_where_the_retargeting_stalls(
    search: StaticSearch, model: ControlledModel, joints: Array
) -> None:
    same, differences = _agreement(search, model, joints, seed=3, count=8)
    assert all(same)
    assert np.median(differences) < 0.002


@pytest.mark.slow
def test_it_agrees_with_the_retargeting_around_the_border_of_the_workspace(
    search: StaticSearch, model: ControlledModel, joints: Array
) -> None:
    same, differences = _agreement(search, model, joints, seed=4, count=40)
    assert np.mean(same) >= 0.97
    assert np.median(differences) < 0.002


def test_what_is_found_stands_within_every_limit(
    search: StaticSearch, standing: DesiredState, model: ControlledModel
) -> None:
    reply = _ask(search, standing, "left_hand", "reach", (1.5, 0.15, 0.9))
    assert not reply.reachable
    assert search.stands()
    limits = Parameters().limits
    torque = np.abs(search.kinematics.static[6:])
    assert (torque <= 1.05 * limits.torque_fraction * model.effort).all()
    for wrench in search.state.wrenches[:2]:
        assert limits.foot_force_min - 1e-6 <= wrench[2] <= limits.foot_force_max + 1e-6
        assert np.abs(wrench[:2]).max() <= limits.friction * wrench[2] + 1e-6


def test_a_preview_does_not_change_what_it_looks_at(
    search: StaticSearch, standing: DesiredState
) -> None:
    before = standing.copy()
    first = _ask(search, standing, "left_hand", "reach", (0.7, 0.3, 0.95))
    _ask(search, standing, "right_hand", "contact", BOOK)
    again = _ask(search, standing, "left_hand", "reach", (0.7, 0.3, 0.95))
    np.testing.assert_array_equal(standing.q, before.q)
    np.testing.assert_array_equal(standing.target_positions, before.target_positions)
    assert standing.enabled == before.enabled
    assert first.reachable
    assert again.distance == pytest.approx(first.distance, abs=1e-4)


def test_balance_is_named_where_it_ends_a_reach(
    search: StaticSearch, standing: DesiredState
) -> None:
    reply = _ask(search, standing, "left_hand", "reach", (1.3, 0.15, 0.9))
    assert not reply.reachable
    assert reply.distance > 0.05
    assert "cm short" in reply.reason
    assert "the end of balance" in reply.reason


def test_a_support_opens_what_was_out_of_reach(
    search: StaticSearch, standing: DesiredState, leaning: DesiredState
) -> None:
    point = (1.2, 0.15, 0.9)
    assert not _ask(search, standing, "left_hand", "reach", point).reachable
    assert _ask(search, leaning, "left_hand", "reach", point).reachable


def test_the_hand_that_leans_leaves_its_support_first(
    search: StaticSearch, leaning: DesiredState
) -> None:
    assert leaning.enabled[RIGHT_HAND]
    assert _ask(search, leaning, "right_hand", "reach", (0.6, -0.3, 1.0)).reachable
    assert not search.state.enabled[RIGHT_HAND]


def test_a_foot_is_freed_only_where_the_other_carries_the_robot(
    search: StaticSearch, standing: DesiredState
) -> None:
    search.start_from(standing)
    assert search.free(0)
    assert search.state.enabled == (False, True, False, False)
    assert not search.free(1)


def test_a_support_that_takes_no_load_is_refused(
    search: StaticSearch, standing: DesiredState
) -> None:
    reply = _ask(search, standing, "right_hand", "contact", BOOK)
    assert reply.reachable
    assert search.state.wrenches[RIGHT_HAND, 2] >= Parameters().limits.hand_force_min
    demanding = Parameters()
    demanding = replace(demanding, limits=replace(demanding.limits, hand_force_min=140.0))
    refused = _ask(
        StaticSearch(search.controlled, demanding), standing, "right_hand", "contact", BOOK
    )
    assert not refused.reachable
    assert "140 N are needed" in refused.reason


def test_a_goal_that_no_controller_takes_is_refused_with_its_reason(
    search: StaticSearch, standing: DesiredState
) -> None:
    reply = _ask(search, standing, "left_hand", "reach", (-0.5, 0.3, 0.9))
    assert not reply.reachable
    assert reply.distance == -1.0
    assert "behind" in reply.reason


def test_loading_uses_the_frame_of_the_surface(search: StaticSearch, joints: Array) -> None:
    search.start(joints)
    search.move(RIGHT_HAND, np.array([0.65, -0.3, 1.0]))
    force = search.load(RIGHT_HAND, frame_from_normal(np.array([-1.0, 0.0, 0.0])))
    assert force >= 0.0
    assert search.stands()


def test_a_robot_that_would_fall_without_its_hand_is_told_of(
    search: StaticSearch, standing: DesiredState, leaning: DesiredState
) -> None:
    alone = _ask(search, standing, "left_hand", "reach", (0.6, 0.3, 1.0))
    assert alone.reachable, alone.reason
    assert alone.reason == ""
    supported = _ask(search, leaning, "left_hand", "reach", (0.95, 0.15, 0.9))
    assert supported.reachable, supported.reason
    lead, limit = search.lead(), search.parameters.supervision.falls_ahead
    assert lead > limit
    assert f"{100 * lead:.1f} cm ahead of its feet, limit 8.0 cm" in supported.reason
    assert "if the right hand lost its support, it would fall" in supported.reason


def test_how_far_is_too_far_is_a_parameter(
    search: StaticSearch, leaning: DesiredState, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = search.parameters
    tolerant = replace(own, supervision=replace(own.supervision, falls_ahead=float("inf")))
    monkeypatch.setattr(search, "parameters", tolerant)
    reply = _ask(search, leaning, "left_hand", "reach", (0.95, 0.15, 0.9))
    assert (reply.reachable, reply.reason) == (True, "")


def test_the_lead_is_along_the_feet(search: StaticSearch, standing: DesiredState) -> None:
    search.start_from(standing)
    mass = search.kinematics.center_of_mass(standing.q)
    middle = search.kinematics.positions[:2].mean(axis=0)
    assert search.lead() == pytest.approx(mass[0] - middle[0], abs=1e-9)
    assert abs(search.lead()) < 0.05
