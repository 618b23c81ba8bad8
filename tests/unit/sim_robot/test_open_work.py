"""Whoever points between the wires of a rack means the rack."""

import numpy as np
import numpy.typing as npt

from w2c_sim_robot.scenes.objects.catalogue import make_object
from w2c_sim_robot.scenes.open_work import fill_open_work
from w2c_sim_robot.scenes.scene import SceneObject

COUNTER, RACK, PLATE, ROBOT = 1, 2, 3, 255
OBJECTS = [
    make_object("counter", "white", (1.0, 0.0, 0.0)),
    make_object("dish_rack", "grey", (1.0, 0.0, 0.9)),
    make_object("plate", "white", (1.0, 0.0, 0.9)),
]


def grid(width: int = 40) -> npt.NDArray[np.uint8]:
    """A rack of wires ten pixels apart, from 10 to 30, on a counter."""
    identity = np.full((40, width), COUNTER, np.uint8)
    for wire in (10, 20, 30):
        identity[wire, 10:31] = identity[10:31, wire] = RACK
    return identity


def filled(
    identity: npt.NDArray[np.uint8], objects: list[SceneObject] = OBJECTS
) -> npt.NDArray[np.uint8]:
    result = identity.copy()
    fill_open_work(objects, result, np.zeros_like(identity))
    return result


def test_the_counter_and_the_room_between_the_wires_are_the_rack() -> None:
    identity = grid()
    identity[12:16, 12:16] = 0

    assert np.all(filled(identity)[10:31, 10:31] == RACK)


def test_a_gap_is_no_part_of_what_shows_through_it() -> None:
    door, wheel = 1, 1
    parts = np.full((40, 40), door, np.uint8)
    identity = grid()
    parts[identity == RACK] = wheel
    fill_open_work(OBJECTS, identity, parts)

    assert parts[12, 12] == 0
    assert parts[10, 10] == wheel
    assert parts[0, 0] == door


def test_what_is_outside_stays() -> None:
    result = filled(grid())
    result[10:31, 10:31] = COUNTER

    assert np.all(result == COUNTER)


def test_a_plate_in_the_rack_and_a_hand_before_it_keep_their_pixels() -> None:
    identity = grid()
    identity[14:18, 5:25] = PLATE
    identity[24:28, 22:40] = ROBOT
    result = filled(identity)

    assert np.array_equal(result == PLATE, identity == PLATE)
    assert np.array_equal(result == ROBOT, identity == ROBOT)
    assert result[12, 12] == RACK


def test_a_rack_out_of_sight_and_a_thing_that_is_no_rack_fill_nothing() -> None:
    hidden = np.full((40, 40), COUNTER, np.uint8)
    ring = grid()
    ring[ring == RACK] = PLATE

    assert np.array_equal(filled(hidden), hidden)
    assert np.array_equal(filled(ring), ring)
