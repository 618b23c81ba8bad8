"""The witness of a simulation, on scene (a): surfaces behind pixels, contacts, poses."""

import numpy as np
import pytest

from w2c.errors import ConfigError
from w2c.messages import Array
from w2c_sim_robot import talos
from w2c_sim_robot.model import ready_configuration
from w2c_sim_robot.scenes.scenario_a import scenario_a
from w2c_sim_robot.witness import FLOOR, ROBOT, Witness


@pytest.fixture(scope="module")
def shared() -> Witness:
    """Build the model once: it takes seconds."""
    return Witness(scenario_a(distractors=False))


@pytest.fixture
def witness(shared: Witness) -> Witness:
    """Stand ready."""
    shared.pose(ready_configuration(shared.model))
    return shared


def bent(witness: Witness, **angles: float) -> Array:
    """Return the ready position with other joint angles."""
    position = ready_configuration(witness.model)
    for joint, angle in angles.items():
        position[witness.model.joint(joint).qposadr[0]] = angle
    return position


def test_the_book_is_seen_where_it_is(witness: Witness) -> None:
    book = next(item for item in witness.objects if item.name == "book")
    top = np.array(book.top_in_world)
    pixel = witness.project(top)
    assert pixel is not None
    seen = witness.surface(*pixel)
    assert seen is not None
    assert seen.owner == "book"
    assert seen.point == pytest.approx(top, abs=0.004)  # the cover lies a little lower
    assert seen.normal == pytest.approx((0.0, 0.0, 1.0), abs=0.01)
    assert witness.owners(np.array([pixel, (640.0, 40.0)])) == ["book", witness_owner(witness)]


def witness_owner(witness: Witness) -> str:
    seen = witness.surface(640.0, 40.0)
    return "" if seen is None else seen.owner


def test_what_is_behind_the_camera_is_in_no_pixel(witness: Witness) -> None:
    assert witness.project(np.array([-2.0, 0.0, 1.0])) is None
    assert witness.project(np.array([0.6, 5.0, 0.8])) is None


def test_a_standing_robot_touches_the_floor_alone(witness: Witness) -> None:
    soles = set(talos.SOLE_FRAMES)
    touching = [c for c in witness.contacts() if c.first in witness.links]
    assert {(c.first, c.second) for c in touching} <= {(sole, FLOOR) for sole in soles}


def test_an_arm_through_the_trunk_is_a_contact_of_the_robot_with_itself(witness: Witness) -> None:
    angles = {"arm_left_2_joint": 0.8, "arm_left_3_joint": -2.2, "arm_left_4_joint": -2.3}
    witness.pose(bent(witness, arm_left_1_joint=-0.2, **angles))
    own = [c for c in witness.contacts() if c.second in witness.links]
    assert own
    assert own[0].depth > 0.005


def test_neighbours_whose_shapes_always_overlap_do_not_meet(witness: Witness) -> None:
    """A robot that bends its hips far: hip and thigh are convex hulls around hollow parts."""
    witness.pose(bent(witness, leg_left_3_joint=-1.8, leg_right_3_joint=-1.8))
    pairs = {frozenset((c.first, c.second)) for c in witness.contacts()}
    assert frozenset(("leg_left_1_link", "leg_left_3_link")) not in pairs
    assert frozenset(("leg_right_1_link", "leg_right_3_link")) not in pairs


def test_a_hand_in_the_table_is_a_contact(witness: Witness) -> None:
    position = ready_configuration(witness.model)
    base = witness.model.joint("base").qposadr[0]
    position[base : base + 3] += (0.25, 0.0, -0.25)
    witness.pose(position)
    touched = {c.second for c in witness.contacts() if c.first in witness.links}
    assert "table" in touched


def test_feet_and_hands_are_told_apart_from_other_links(witness: Witness) -> None:
    effectors = witness.effectors
    assert effectors["left_sole_link"] == 0
    assert effectors["right_sole_link"] == 1
    assert effectors["wrist_left_ft_link"] == 2
    assert effectors["right_hand_frame"] == 3
    assert "arm_right_4_link" not in effectors
    assert "table" not in witness.links


def test_positions_of_another_scene_are_refused(witness: Witness) -> None:
    with pytest.raises(ConfigError, match="another scene"):
        witness.pose(np.zeros(3))
    with pytest.raises(ConfigError, match="no object 'spoon'"):
        witness.world_from_object("spoon")
    assert ROBOT not in {item.name for item in witness.objects}
