"""Perturbations do what they say, and the controller is not told."""

import msgspec
import numpy as np
import pytest

from w2c.errors import ConfigError
from w2c.messages import Array
from w2c_sim_robot.perturbation import Perturbation, raise_scene
from w2c_sim_robot.physics import Simulator
from w2c_sim_robot.scenes.scenario_a import scenario_a
from w2c_sim_robot.sensor_errors import JointErrors, SensorErrors
from w2c_sim_robot.study import Block, loaded_description, study_robot

GRAVITY = 9.81


def hold(robot: Simulator, seconds: float) -> None:
    for _ in range(round(seconds * 500)):
        robot.step(robot.command)


def lean_on(robot: Simulator, block_top: float) -> None:
    """Bring the right hand down onto a block until it carries weight."""
    command = robot.command
    shoulder, elbow = 21, 24
    start = command.copy()
    for tick in range(2000):
        share = min((tick + 1) / 1500, 1.0)
        command[shoulder] = start[shoulder] + 0.15 * share
        command[elbow] = start[elbow] + 0.5 * share
        robot.step(command)
    assert robot.truth().end_effector_positions[3, 2] < block_top + 0.06


def test_a_mass_in_the_hand_weighs_on_the_feet_and_on_the_wrist() -> None:
    mass = 3.0
    empty, loaded = study_robot(), study_robot(Perturbation(hand_mass=(mass, 0.0)))
    for robot in (empty, loaded):
        hold(robot, 2.0)
    weights = [robot.state().sole_wrenches[:, 2].sum() for robot in (empty, loaded)]
    assert weights[1] - weights[0] == pytest.approx(mass * GRAVITY, abs=2.0)
    wrist = loaded.state().left_wrist_wrench
    assert np.linalg.norm(wrist[:3]) == pytest.approx(mass * GRAVITY, abs=0.3)
    assert wrist[3:] == pytest.approx(np.zeros(3), abs=0.1)  # at the hand's frame
    assert empty.state().left_wrist_wrench == pytest.approx(np.zeros(6), abs=0.1)


def test_a_mass_in_the_ball_weighs_on_the_arm() -> None:
    mass = 5.0
    torques = []
    for perturbation in (Perturbation(), Perturbation(hand_mass=(0.0, mass))):
        robot = study_robot(perturbation)
        hold(robot, 2.0)
        torques.append(robot.state().torque)
    change = np.abs(torques[1] - torques[0])
    assert change[-6:-2].max() > 10.0  # the right arm
    assert change[14:21].max() < 1.0  # the left arm


def test_the_described_load_is_the_simulated_one() -> None:
    import pinocchio as pin

    masses = (2.0, 7.0)
    robot = study_robot(Perturbation(hand_mass=masses))
    model = pin.buildModelFromXML(loaded_description(masses).urdf, pin.JointModelFreeFlyer())
    assert pin.computeTotalMass(model) == pytest.approx(robot.model.body_mass.sum(), abs=1e-9)


@pytest.mark.parametrize(("friction", "slides"), [(0.3, True), (0.8, False)])
def test_friction_decides_whether_the_feet_slide(friction: float, slides: bool) -> None:
    robot = study_robot(Perturbation(friction=friction / 0.8))
    start = robot.truth().end_effector_positions[:2].copy()
    foot_load = 0.5 * robot.model.body_mass.sum() * GRAVITY
    robot.push(np.array([0.55 * foot_load, 0.0, 0.0]), 0.1, "leg_left_6_link")
    hold(robot, 0.1)
    moved = float(np.abs(robot.truth().end_effector_positions[:2] - start)[:, :2].max())
    assert (moved > 0.003) == slides


@pytest.mark.parametrize("pitch", [0.04, -0.04])
def test_a_wedge_moves_the_pressure_to_the_edge_that_it_leaves_on_the_ground(pitch: float) -> None:
    robot = study_robot(Perturbation(sole_pitch=(0.0, pitch)))
    hold(robot, 3.0)
    assert not robot.fell
    wrench = robot.state().sole_wrenches[1]
    pressure = -wrench[4] / wrench[2]
    assert np.sign(pressure) == np.sign(pitch)
    assert 0.05 < abs(pressure) < 0.101


def test_a_block_holds_the_hand_up() -> None:
    block = Block(centre=(0.55, -0.3, 0.45), half_size=(0.3, 0.3, 0.45))
    robot = study_robot(blocks=(block,))
    lean_on(robot, 0.9)
    force = robot.truth().contact_forces[3]
    assert force[2] > 5.0
    assert not robot.fell


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"hand_mass": (0.0, 80.0)}, "hand mass 80 kg"),
        ({"hand_mass": (-1.0, 0.0)}, "hand mass -1 kg"),
        ({"sole_pitch": (0.5, 0.0)}, "sole pitch 0.5 rad"),
        ({"stiffness": float("nan")}, "stiffness scale nan"),
        ({"ball_friction": 0.01}, "ball_friction scale 0.01"),
    ],
)
def test_what_is_no_robot_is_refused(values: dict[str, Array], words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        Perturbation(**values)  # type: ignore[arg-type]


def test_a_slippery_ball_leaves_the_feet_their_grip() -> None:
    slippery, usual = study_robot(Perturbation(ball_friction=0.375)).model, study_robot().model
    ball = usual.geom_bodyid == usual.body("right_hand_frame").id
    assert slippery.geom_friction[ball, 0] == pytest.approx([0.3])
    assert slippery.geom_friction[~ball].tolist() == usual.geom_friction[~ball].tolist()


def test_a_raised_scene_leaves_what_is_loose_on_the_floor() -> None:
    scene = scenario_a()
    ball = msgspec.structs.replace(scene.object("cup"), name="ball", position=(1.0, 0.5, 0.0))
    scene = msgspec.structs.replace(scene, objects=(*scene.objects, ball))
    raised = raise_scene(scene, 0.02)
    moved = [
        new.position[2] - old.position[2]
        for old, new in zip(scene.objects, raised.objects, strict=True)
    ]
    assert moved == pytest.approx([*(len(moved) - 1) * [0.02], 0.0])


def test_a_block_is_raised_too() -> None:
    block = Block(centre=(0.55, -0.3, 0.45), half_size=(0.3, 0.3, 0.45))
    model = study_robot(Perturbation(table_height=0.05), (block,)).model
    assert model.geom("block_0").pos[2] == pytest.approx(0.5)


def test_the_sensors_of_a_study_err_by_its_seed() -> None:
    biased = SensorErrors(torque=JointErrors(bias=3.0))
    with pytest.raises(ConfigError, match="need a generator"):
        study_robot(sensors=biased)
    robots = [study_robot(sensors=biased, generator=np.random.default_rng(s)) for s in (1, 1, 2)]
    torques = [robot.state().torque.tolist() for robot in robots]
    assert torques[0] == torques[1] != torques[2]
    assert robots[0].state().position.tolist() == robots[2].state().position.tolist()
