"""Forces from outside: when they act, how they add up, and which are refused."""

from typing import Any

import mujoco
import numpy as np
import pytest

from w2c.errors import ControlError
from w2c.messages import Array
from w2c_sim_robot.pushes import Pushes

XML = """
<mujoco><worldbody>
  <body name="left"><freejoint/><geom size="0.1" mass="1"/></body>
  <body name="right" pos="1 0 0"><freejoint/><geom size="0.1" mass="1"/></body>
</worldbody></mujoco>
"""


@pytest.fixture
def data() -> mujoco.MjData:
    return mujoco.MjData(mujoco.MjModel.from_xml_string(XML))


def forces(pushes: Pushes, data: mujoco.MjData, ticks: int) -> list[list[float]]:
    """Return the forces along x on both bodies during each tick."""
    seen = []
    for tick in range(ticks):
        pushes.begin(tick)
        seen.append(data.xfrc_applied[1:, 0].tolist())
        pushes.end(tick + 1)
    return seen


def test_a_push_acts_for_its_time_from_its_tick_on(data: mujoco.MjData) -> None:
    pushes = Pushes(data.model, data, 2_000_000)
    assert pushes.add(np.array([5.0, 0.0, 0.0]), 0.004, "right", now=0, tick=2) == 2
    assert forces(pushes, data, 5) == [[0, 0], [0, 0], [0, 5], [0, 5], [0, 0]]


def test_pushes_add_up_and_end_one_by_one(data: mujoco.MjData) -> None:
    pushes = Pushes(data.model, data, 2_000_000)
    pushes.add(np.array([5.0, 0.0, 0.0]), 0.006, "left", now=0)
    pushes.add(np.array([3.0, 0.0, 0.0]), 0.0, "left", now=0, tick=1)
    pushes.add(np.array([-1.0, 0.0, 0.0]), 0.002, "right", now=0)
    assert forces(pushes, data, 4) == [[5, -1], [8, 0], [5, 0], [0, 0]]


def test_after_a_reset_nothing_pushes(data: mujoco.MjData) -> None:
    pushes = Pushes(data.model, data, 2_000_000)
    pushes.add(np.array([5.0, 0.0, 0.0]), 1.0, "left", now=0)
    pushes.reset()
    assert forces(pushes, data, 2) == [[0, 0], [0, 0]]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"link": "middle"}, "no body 'middle' to push; there are: left, right"),
        ({"link": "world"}, "no body 'world'"),
        ({"force": np.array([1.0, 2.0])}, "three finite numbers"),
        ({"force": np.array([1.0, np.nan, 0.0])}, "three finite numbers"),
        ({"force": np.array([0.0, 6000.0, 0.0])}, "6000 N is beyond 5000 N"),
        ({"duration_s": -1.0}, "-1 s is outside 0 to 60 s"),
        ({"duration_s": float("nan")}, "outside 0 to 60 s"),
        ({"tick": 6}, "tick 6 on is too late: the robot is at 7"),
    ],
)
def test_bad_pushes_are_refused(data: mujoco.MjData, changes: dict[str, Any], words: str) -> None:
    values: dict[str, Array | Any] = {
        "force": np.array([1.0, 0.0, 0.0]),
        "duration_s": 0.1,
        "link": "left",
    }
    with pytest.raises(ControlError, match=words):
        Pushes(data.model, data, 2_000_000).add(**{**values, **changes}, now=7)
