"""Ideal sensors read what MuJoCo has, from the right places."""

import mujoco
import numpy as np
import pytest

from w2c.messages import Array
from w2c_sim_robot import talos
from w2c_sim_robot.model import build_model
from w2c_sim_robot.sensing import Channels, ForceTorqueSensor, Gather, IdealSensors


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return build_model(visuals=False)


@pytest.fixture
def moving(model: mujoco.MjModel) -> mujoco.MjData:
    """A robot in the air, turned, every joint on its way."""
    data = mujoco.MjData(model)
    rng = np.random.default_rng(1)
    data.qpos[7:] = rng.uniform(-0.3, 0.3, model.nq - 7)
    data.qpos[:7] = (0.3, -0.2, 2.0, *rng.normal(size=4))
    data.qvel[:] = rng.normal(size=model.nv)
    data.ctrl[:] = rng.uniform(-0.2, 0.2, model.nu)
    mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    return data


def test_gathering_finds_numbers_of_many_arrays_and_follows_them(
    model: mujoco.MjModel, moving: mujoco.MjData
) -> None:
    gather = Gather(
        moving, [(moving.qvel, [3, 1]), (moving.xmat, [10]), (moving.qpos, range(2, 4))]
    )
    assert gather.read().tolist() == [
        *moving.qvel[[3, 1]].tolist(),
        float(moving.xmat.reshape(-1)[10]),
        *moving.qpos[2:4].tolist(),
    ]
    moving.qvel[1] = 42.0
    assert gather.read()[1] == 42.0
    mujoco.mj_resetData(model, moving)
    assert gather.read()[0] == 0.0


def test_every_channel_reads_its_sensor(model: mujoco.MjModel, moving: mujoco.MjData) -> None:
    channels = Channels(len(talos.ACTUATED))
    reading = IdealSensors(model, moving, channels, talos.ACTUATED).read()
    assert reading.shape == (channels.width,)
    joints = [moving.joint(name) for name in talos.ACTUATED]
    expected: dict[str, list[float]] = {
        "position": [float(joint.qpos[0]) for joint in joints],
        "velocity": [float(joint.qvel[0]) for joint in joints],
        "torque": [float(joint.qfrc_actuator[0]) for joint in joints],
        "orientation": np.roll(moving.sensor("imu_orientation").data, -1).tolist(),
        "angular_velocity": moving.sensor("imu_angular_velocity").data.tolist(),
        "acceleration": moving.sensor("imu_linear_acceleration").data.tolist(),
    }
    for name, values in expected.items():
        assert reading[getattr(channels, name)].tolist() == values, name


def textbook_wrench(model: mujoco.MjModel, data: mujoco.MjData, name: str, frame: str) -> Array:
    """Return the wrench (6,) of a force-torque sensor by the rules of statics, with matrices."""
    links = {"left_sole": "left_sole_link", "left_wrist": talos.WRIST_SENSOR_LINK}
    link = model.body(links[name]).id
    site, body = data.site(name), data.body(frame)
    world_from_site, world_from_frame = site.xmat.reshape(3, 3), body.xmat.reshape(3, 3)
    weight = model.body_subtreemass[link] * model.opt.gravity
    force = -world_from_site @ data.sensor(f"{name}_force").data - weight
    about_site = -world_from_site @ data.sensor(f"{name}_torque").data - np.cross(
        data.subtree_com[link] - site.xpos, weight
    )
    about_frame = about_site + np.cross(site.xpos - body.xpos, force)
    return np.concatenate([world_from_frame.T @ force, world_from_frame.T @ about_frame])


@pytest.mark.parametrize(
    ("name", "frame", "rows"),
    [
        ("left_sole", talos.SOLE_FRAMES[0], slice(0, 6)),
        ("left_wrist", talos.HAND_FRAMES[0], slice(12, 18)),
    ],
)
def test_wrenches_agree_with_statics(
    model: mujoco.MjModel, moving: mujoco.MjData, name: str, frame: str, rows: slice
) -> None:
    channels = Channels(len(talos.ACTUATED))
    reading = IdealSensors(model, moving, channels, talos.ACTUATED).read()
    expected = textbook_wrench(model, moving, name, frame)
    assert np.abs(expected).max() > 1.0
    assert reading[channels.wrenches][rows] == pytest.approx(expected, abs=1e-9)


def test_an_unknown_mass_is_felt_at_the_frame(model: mujoco.MjModel, moving: mujoco.MjData) -> None:
    wrenches = []
    for mass in (0.0, 2.0):
        sensor = ForceTorqueSensor(
            model, "left_wrist", talos.WRIST_SENSOR_LINK, talos.HAND_FRAMES[0], unknown=mass
        )
        wrenches.append(
            np.array(sensor.wrench(Gather(moving, sensor.places(moving)).read().tolist()))
        )
    hand = moving.body(talos.HAND_FRAMES[0]).xmat.reshape(3, 3)
    change = wrenches[1] - wrenches[0]
    assert hand @ change[:3] == pytest.approx([0.0, 0.0, -2.0 * 9.81])
    assert change[3:].tolist() == [0.0, 0.0, 0.0]
