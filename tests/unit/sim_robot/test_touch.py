"""Who touches what: asked cheaply at every tick, and how hard."""

import mujoco
import numpy as np
import pytest

from w2c_sim_robot import talos
from w2c_sim_robot.model import build_model, ready_configuration
from w2c_sim_robot.touch import LOOK_EVERY, Touch


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return build_model(visuals=False)


@pytest.fixture
def data(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[:] = ready_configuration(model)
    mujoco.mj_forward(model, data)
    return data


def put(model: mujoco.MjModel, data: mujoco.MjData, height: float, pitch: float) -> None:
    """Put the stiff robot somewhere, turned about its y axis."""
    data.qpos[:] = ready_configuration(model)
    data.qpos[2] += height
    data.qpos[3:7] = (np.cos(pitch / 2), 0.0, np.sin(pitch / 2), 0.0)
    mujoco.mj_forward(model, data)


def test_feet_on_the_floor_are_no_fall_and_carry_what_they_carry(
    model: mujoco.MjModel, data: mujoco.MjData
) -> None:
    touch = Touch(model, data)
    assert data.ncon > 0
    assert not touch.by_body(1)
    forces = touch.forces()
    assert forces[:2, 2].min() > 0.0
    assert forces[2:].tolist() == [[0.0] * 3] * 2


def test_a_lying_robot_is_seen_at_once(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    touch = Touch(model, data)
    assert not touch.by_body(1)
    put(model, data, -0.9, np.pi / 2)
    assert touch.by_body(2)
    put(model, data, 1.0, 0.0)
    assert not touch.by_body(3)


def test_other_contacts_of_the_same_number_are_seen_within_five_ticks(
    model: mujoco.MjModel, data: mujoco.MjData
) -> None:
    touch = Touch(model, data)
    assert not touch.by_body(1)
    torso = int(np.flatnonzero(model.geom_bodyid == model.body("torso_2_link").id)[0])
    soles = [int(model.body(name).geomadr[0]) for name in talos.SOLE_FRAMES]
    for contact in data.contact:
        contact.geom[:] = [torso if geom in soles else geom for geom in contact.geom]
    seen = [touch.by_body(tick) for tick in range(2, 2 + LOOK_EVERY)]
    assert seen == [False] * 3 + [True] * 2


def test_a_reset_forgets(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Also where as many contacts as before are others."""
    touch = Touch(model, data)
    put(model, data, -0.9, np.pi / 2)
    assert touch.by_body(1)
    sole = int(model.body(talos.SOLE_FRAMES[0]).geomadr[0])
    for contact in data.contact:
        contact.geom[:] = [0, sole]
    assert touch.by_body(1)
    touch.reset()
    assert not touch.by_body(1)
