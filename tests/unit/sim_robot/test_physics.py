"""The simulated robot stands, feels its weight, gives way like springs, and repeats itself."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from w2c.errors import ConfigError, ControlError
from w2c.messages import Array, RobotDescription
from w2c_sim_robot import talos
from w2c_sim_robot.description import make_description
from w2c_sim_robot.model import (
    WORLD_CONAFFINITY,
    WORLD_CONTYPE,
    build_model,
    build_spec,
)
from w2c_sim_robot.perturbation import Perturbation
from w2c_sim_robot.physics import Simulator
from w2c_sim_robot.scenes.scenario_a import scenario_a
from w2c_sim_robot.sensor_errors import typical

TICKS_PER_SECOND = 500


@pytest.fixture(scope="module")
def description() -> RobotDescription:
    return make_description()


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return build_model()


@pytest.fixture
def robot(model: mujoco.MjModel, description: RobotDescription) -> Simulator:
    return Simulator(model, description)


def index_of(name: str) -> int:
    return talos.ACTUATED.index(name)


def hold(robot: Simulator, seconds: float) -> float:
    """Hold the command in force. Returns the largest drift of the base meanwhile [m]."""
    start = robot.truth().world_from_base[:3]
    drift = 0.0
    for tick in range(round(seconds * TICKS_PER_SECOND)):
        robot.step(robot.command)
        if tick % 10 == 0:
            moved = np.linalg.norm(robot.truth().world_from_base[:3] - start)
            drift = max(drift, float(moved))
    return drift


def go(robot: Simulator, command: Array, seconds: float) -> None:
    """Move linearly to a command."""
    start = robot.command
    ticks = round(seconds * TICKS_PER_SECOND)
    for tick in range(1, ticks + 1):
        robot.step(start + (command - start) * tick / ticks)


def test_stands_for_30_seconds_within_half_a_millimetre(robot: Simulator) -> None:
    drift = hold(robot, 30.0)
    assert not robot.fell
    assert drift < 0.0005
    assert np.abs(robot.state().velocity).max() < 1e-4


def test_world_is_midway_between_the_soles(robot: Simulator) -> None:
    soles = robot.truth().end_effector_positions[:2]
    assert soles.mean(axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert soles[0, 1] > 0 > soles[1, 1]


def test_starts_in_the_described_posture_with_a_command_that_bears_its_weight(
    robot: Simulator, description: RobotDescription
) -> None:
    state = robot.state()
    assert state.position == pytest.approx(description.initial_position)
    stiffness = np.array([joint.stiffness for joint in description.joints])
    wound_up = stiffness * (state.command - state.position)
    hold(robot, 2.0)
    assert robot.state().torque == pytest.approx(wound_up, abs=2.0)
    assert np.abs(wound_up).max() > 40.0  # the knees


def test_sole_wrenches_bear_the_weight_and_equal_the_contact_forces(robot: Simulator) -> None:
    hold(robot, 2.0)
    wrenches = robot.state().sole_wrenches
    weight = robot.model.body_mass.sum() * 9.81
    assert wrenches[:, 2].sum() == pytest.approx(weight, abs=0.5)
    # The soles are level: their frames are parallel to the world's.
    assert wrenches[:, :3] == pytest.approx(robot.truth().contact_forces[:2], abs=0.1)


def test_centre_of_pressure_is_under_the_centre_of_mass(robot: Simulator) -> None:
    hold(robot, 2.0)
    wrenches, soles = robot.state().sole_wrenches, robot.truth().end_effector_positions[:2]
    force = wrenches[:, 2]
    # A force fz at (x, y) in the sole frame has moments tx = y fz, ty = -x fz.
    pressure_x = (soles[:, 0] * force - wrenches[:, 4]).sum() / force.sum()
    pressure_y = (soles[:, 1] * force + wrenches[:, 3]).sum() / force.sum()
    data = mujoco.MjData(robot.model)
    data.qpos[:] = robot.truth().generalized_position
    mujoco.mj_forward(robot.model, data)
    assert [pressure_x, pressure_y] == pytest.approx(data.subtree_com[0][:2], abs=5e-4)


def test_free_hand_feels_nothing_whatever_its_posture(robot: Simulator) -> None:
    command = robot.command
    command[index_of("arm_left_4_joint")] += 0.4
    command[index_of("arm_left_6_joint")] += 0.5
    go(robot, command, 2.0)
    hold(robot, 2.0)
    assert robot.state().left_wrist_wrench == pytest.approx(np.zeros(6), abs=0.02)


def test_wrist_feels_what_pushes_the_hand_in_and_at_the_hand_frame(robot: Simulator) -> None:
    force, link = np.array([5.0, -3.0, 12.0]), "gripper_left_base_link"
    robot.push(force, 20.0, link)
    hold(robot, 4.0)
    data = mujoco.MjData(robot.model)
    data.qpos[:] = robot.truth().generalized_position
    mujoco.mj_forward(robot.model, data)
    hand = data.body("left_hand_frame")
    hand_from_world = hand.xmat.reshape(3, 3).T
    torque = np.cross(data.body(link).xipos - hand.xpos, force)
    expected = np.concatenate([hand_from_world @ force, hand_from_world @ torque])
    assert robot.state().left_wrist_wrench == pytest.approx(expected, abs=0.02)


def test_truth_is_of_the_moment_it_is_stamped_with(robot: Simulator) -> None:
    """While the robot moves, positions and configuration belong together."""
    start = robot.truth()
    assert start.world_from_base[3:] == pytest.approx([0.0, 0.0, 0.0, 1.0], abs=1e-6)
    robot.push(np.array([60.0, 0.0, 0.0]), 0.1)
    hold(robot, 0.1)
    truth = robot.truth()
    data = mujoco.MjData(robot.model)
    data.qpos[:] = truth.generalized_position
    mujoco.mj_forward(robot.model, data)
    hands = [data.body(name).xpos for name in talos.HAND_FRAMES]
    assert np.linalg.norm(hands[1] - start.end_effector_positions[3]) > 1e-3
    assert truth.end_effector_positions[2:] == pytest.approx(np.array(hands), abs=1e-9)


def test_without_the_elastic_offset_the_robot_sags(
    robot: Simulator, description: RobotDescription
) -> None:
    """The springs are real: commanding the posture itself lets the weight bend the knees."""
    go(robot, description.initial_position, 1.0)
    hold(robot, 3.0)
    knee = index_of("leg_left_4_joint")
    sag = robot.state().position[knee] - description.initial_position[knee]
    assert 0.005 < sag < 0.03
    assert not robot.fell


def test_joint_vectors_follow_the_description_by_name(robot: Simulator) -> None:
    """Each joint in turn, against MuJoCo's own order, which differs."""
    data = mujoco.MjData(robot.model)
    for index, name in enumerate(talos.ACTUATED):
        robot.reset()
        command = robot.command
        command[index] += 0.02
        go(robot, command, 0.2)
        data.qpos[:] = robot.truth().generalized_position
        assert robot.state().position[index] == float(data.joint(name).qpos[0])
        assert robot.state().position[index] == pytest.approx(talos.READY[name] + 0.02, abs=0.015)


def test_command_is_interpolated_over_the_two_steps_of_a_tick(
    robot: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A recording step in the place of MuJoCo's shows what the actuators are told."""
    told: list[float] = []
    actuator = robot.model.actuator("head_2_joint").id
    real_step = mujoco.mj_step

    def record(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        told.append(float(data.ctrl[actuator]))
        real_step(model, data)

    monkeypatch.setattr(mujoco, "mj_step", record)
    command = robot.command
    start = command[-1]
    command[-1] += 0.01
    robot.step(command)
    robot.step(command)
    assert told == pytest.approx([start + 0.005, start + 0.01, start + 0.01, start + 0.01])


def test_same_commands_give_the_same_bits(
    model: mujoco.MjModel, description: RobotDescription
) -> None:
    """Reading truth or not must not change anything either."""
    states = []
    for read_truth in (False, True):
        robot = Simulator(model, description, sensors=typical(), generator=np.random.default_rng(3))
        command = robot.command
        for tick in range(300):
            command[index_of("arm_right_4_joint")] += 2e-4 * np.sin(tick / 20)
            if tick == 100:
                robot.push(np.array([20.0, 0.0, 0.0]), 0.05)
            robot.step(command)
            if read_truth:
                robot.truth()
        states.append(robot.state())
        again = robot.state()
        assert again.torque.tobytes() == states[-1].torque.tobytes()
    for name in ("position", "velocity", "torque", "sole_wrenches", "imu_linear_acceleration"):
        assert getattr(states[0], name).tobytes() == getattr(states[1], name).tobytes(), name


def test_reset_begins_anew(robot: Simulator) -> None:
    before = robot.state()
    hold(robot, 0.2)
    robot.reset()
    after = robot.state()
    assert after.tick == 0
    assert after.position.tobytes() == before.position.tobytes()
    assert after.sole_wrenches.tobytes() == before.sole_wrenches.tobytes()


def test_push_moves_the_robot_but_does_not_fell_it(robot: Simulator) -> None:
    start = robot.truth().world_from_base[:3]
    robot.push(np.array([60.0, 0.0, 0.0]), 0.1)
    peak = hold(robot, 4.0)
    assert not robot.fell
    assert 0.001 < peak < 0.03
    assert robot.truth().world_from_base[:3] == pytest.approx(start, abs=0.001)


def test_hard_push_fells_it_and_that_is_remembered(robot: Simulator) -> None:
    robot.push(np.array([700.0, 0.0, 0.0]), 0.4)
    for _ in range(3 * TICKS_PER_SECOND):
        robot.step(robot.command)
    assert robot.fell
    assert robot.truth().fell
    robot.reset()
    assert not robot.fell


def test_ball_hand_leans_on_a_box_without_falling(description: RobotDescription) -> None:
    """A box under the right hand takes load: no fall, but seen in truth, torque and feet."""
    spec = build_spec()
    ball = Simulator(spec.compile(), description).truth().end_effector_positions[3]
    height = ball[2] - talos.BALL_RADIUS - 0.002
    spec.worldbody.add_geom(
        name="support",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=(ball[0] + 0.1, ball[1], height / 2),
        size=(0.15, 0.1, height / 2),
        contype=WORLD_CONTYPE,
        conaffinity=WORLD_CONAFFINITY,
    )
    robot = Simulator(spec.compile(), description)
    free_torque = robot.state().torque
    command = robot.command
    command[index_of("arm_right_4_joint")] += 0.06  # stretches the elbow: the ball goes down
    go(robot, command, 1.0)
    hold(robot, 2.0)
    truth = robot.truth()
    assert not robot.fell
    assert 20.0 < truth.contact_forces[3, 2] < 250.0
    elbow = index_of("arm_right_4_joint")
    assert abs(robot.state().torque[elbow] - free_torque[elbow]) > 5.0
    feet = robot.state().sole_wrenches[:, 2].sum()
    weight = robot.model.body_mass.sum() * 9.81
    assert feet + truth.contact_forces[3, 2] == pytest.approx(weight, abs=1.0)


@pytest.mark.parametrize("command", [np.zeros(25), np.full(27, np.nan)])
def test_malformed_commands_are_refused(robot: Simulator, command: Array) -> None:
    with pytest.raises(ControlError, match="finite angles"):
        robot.step(command)


def test_perturbation_changes_the_robot_but_not_its_description(model: mujoco.MjModel) -> None:
    other = build_model(perturbation=Perturbation(stiffness=0.5, friction=0.5, mass=1.1))
    knee, ball = "leg_left_4_joint", int(model.body("right_hand_frame").geomadr[0]) + 2
    assert other.actuator(knee).gainprm[0] == 0.5 * model.actuator(knee).gainprm[0]
    assert other.actuator(knee).biasprm[1] == -other.actuator(knee).gainprm[0]
    assert other.body_mass.sum() == pytest.approx(1.1 * model.body_mass.sum())
    assert other.geom_friction[ball, 0] == pytest.approx(0.4)
    with pytest.raises(ConfigError, match="stiffness scale 0"):
        Perturbation(stiffness=0.0)


@pytest.mark.parametrize("stiffness", [0.5, 2.0])
def test_a_robot_that_is_not_as_described_starts_in_equilibrium_too(
    description: RobotDescription, stiffness: float
) -> None:
    robot = Simulator(build_model(perturbation=Perturbation(stiffness=stiffness)), description)
    assert hold(robot, 3.0) < 0.002


def test_physics_does_not_depend_on_what_is_drawn() -> None:
    drawn, bare = build_model(scenario_a()), build_model(scenario_a(), visuals=False)
    assert bare.ngeom < drawn.ngeom
    assert bare.body_mass.tolist() == drawn.body_mass.tolist()
    assert bare.body_inertia.tolist() == drawn.body_inertia.tolist()
    assert bare.qpos0.tolist() == drawn.qpos0.tolist()


def test_robot_stands_before_the_table_and_truth_names_the_movable_objects(
    description: RobotDescription,
) -> None:
    robot = Simulator(build_model(scenario_a(), visuals=False), description)
    hold(robot, 1.0)
    assert not robot.fell
    truth = robot.truth()
    assert truth.generalized_position.shape == (robot.model.nq,)
    assert truth.scene["cup"] == pytest.approx((1.08, 0.16, 0.80), abs=0.005)
    assert "base_link" not in truth.scene


def test_diverged_physics_is_an_error_not_a_fresh_start(
    robot: Simulator, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log of its own where it runs
    robot.model.opt.gravity[2] = np.inf
    try:
        with pytest.raises(ControlError, match="diverged at tick 0"):
            robot.step(robot.command)
    finally:
        robot.model.opt.gravity[2] = -9.81
    robot.reset()
    robot.step(robot.command)


def test_imu_feels_gravity_and_stands_upright(robot: Simulator) -> None:
    hold(robot, 1.0)
    state = robot.state()
    assert np.linalg.norm(state.imu_linear_acceleration) == pytest.approx(9.81, abs=0.01)
    assert np.linalg.norm(state.imu_orientation) == pytest.approx(1.0)
    data = mujoco.MjData(robot.model)
    data.qpos[:] = robot.truth().generalized_position
    mujoco.mj_forward(robot.model, data)
    expected = np.roll(data.body(talos.IMU_LINK).xquat, -1)
    assert abs(float(expected @ state.imu_orientation)) == pytest.approx(1.0, abs=1e-6)
