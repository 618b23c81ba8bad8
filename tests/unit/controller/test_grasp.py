"""How an open hand points at what it reaches for, and that its fingertips stay off it."""

import math

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c.geometry import unit
from w2c.messages import Array
from w2c_controller.motion.grasp import (
    FARTHEST_STANDOFF,
    FINGERTIPS,
    FLATTEST,
    LARGEST_TURN,
    REACH_STANDOFF,
    STEEPEST,
    STEEPEST_OVER,
    TIP_MARGIN,
    approach_direction,
    pointing_rotation,
    standoff,
)
from w2c_sim_robot import talos
from w2c_sim_robot.model import build_spec
from w2c_sim_robot.scenes.scenario_d import scenario_d

POINT = np.array([1.2, 0.16, 0.8])
AHEAD = unit([1.2, 0.16, 0.0])


def _upright(turned: float) -> Array:
    """Return the normal of an upright surface that faces a robot, turned by an angle [rad]."""
    c, s = math.cos(turned), math.sin(turned)
    return np.array([-c * AHEAD[0] + s * AHEAD[1], -s * AHEAD[0] - c * AHEAD[1], 0.0])


def _pitch(fingers: Array) -> float:
    return math.asin(-float(fingers[2]))


def _tips_off(fingers: Array, normal: Array) -> float:
    """Return how far the nearest fingertip is from the surface where the hand stops [m]."""
    tips = standoff(fingers, normal) * normal + FINGERTIPS @ pointing_rotation(fingers).T
    return float((tips @ normal).min())


@pytest.mark.parametrize("turned", [-0.5, -0.2, 0.0, 0.3])
def test_fingers_turn_towards_an_upright_surface(turned: float) -> None:
    fingers = approach_direction(POINT, _upright(turned))
    level = unit([fingers[0], fingers[1], 0.0])
    np.testing.assert_allclose(level, -_upright(turned), atol=1e-9)
    assert _pitch(fingers) == pytest.approx(FLATTEST)


@pytest.mark.parametrize("turned", [-1.2, 1.2])
def test_fingers_turn_only_so_far(turned: float) -> None:
    fingers = approach_direction(POINT, _upright(turned))
    angle = math.acos(float(unit([fingers[0], fingers[1], 0.0]) @ AHEAD))
    assert angle == pytest.approx(LARGEST_TURN)


def test_above_a_level_surface_fingers_point_straight_ahead_and_down() -> None:
    fingers = approach_direction(POINT, np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(unit([fingers[0], fingers[1], 0.0]), AHEAD)
    assert _pitch(fingers) == pytest.approx(STEEPEST)


def test_fingers_point_down_more_when_asked_up_to_a_limit() -> None:
    normal = _upright(0.0)
    steeper = approach_direction(POINT, normal, math.radians(20.0))
    assert _pitch(steeper) == pytest.approx(FLATTEST + math.radians(20.0))
    assert _pitch(approach_direction(POINT, normal, 2.0)) == pytest.approx(STEEPEST_OVER)


def test_a_surface_behind_itself_turns_no_fingers() -> None:
    fingers = approach_direction(POINT, AHEAD)
    np.testing.assert_allclose(unit([fingers[0], fingers[1], 0.0]), AHEAD)


@given(azimuth=st.floats(-0.5, 0.5), elevation=st.floats(0.0, math.pi / 2))
def test_no_fingertip_touches_what_faces_the_robot(azimuth: float, elevation: float) -> None:
    normal = math.cos(elevation) * _upright(azimuth) + math.sin(elevation) * np.array([0, 0, 1.0])
    fingers = approach_direction(POINT, normal)
    off = standoff(fingers, normal)
    assert REACH_STANDOFF <= off <= FARTHEST_STANDOFF
    if off < FARTHEST_STANDOFF:
        assert _tips_off(fingers, normal) >= TIP_MARGIN - 1e-9
    assert _tips_off(fingers, normal) > 0.0


def test_the_fingertips_are_those_of_the_robot() -> None:
    model = build_spec(scenario_d(seed=0)).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    wrist = model.body("arm_left_7_link").id
    rotation = data.xmat[wrist].reshape(3, 3)
    corners = []
    for geom in range(model.ngeom):
        name = model.body(model.geom_bodyid[geom]).name
        if "gripper_left_fingertip" in name and model.geom_contype[geom]:
            mesh = model.geom_dataid[geom]
            begin = model.mesh_vertadr[mesh]
            vertices = model.mesh_vert[begin : begin + model.mesh_vertnum[mesh]]
            world = vertices @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
            corners.append((world - data.xpos[wrist]) @ rotation - talos.LEFT_HAND_OFFSET)
    found = np.concatenate(corners)
    np.testing.assert_allclose(found[:, :2].max(axis=0), FINGERTIPS[:, :2].max(axis=0), atol=2e-3)
    np.testing.assert_allclose(found[:, :2].min(axis=0), FINGERTIPS[:, :2].min(axis=0), atol=2e-3)
    assert found[:, 2].min() == pytest.approx(FINGERTIPS[:, 2].min(), abs=3e-3)
