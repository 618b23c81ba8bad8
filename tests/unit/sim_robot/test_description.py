"""One string describes the robot to the controller and to the simulator."""

from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from w2c.driver.limits import joint_limits
from w2c.errors import ConfigError
from w2c.messages import Array, RobotDescription
from w2c_sim_robot import talos
from w2c_sim_robot.description import make_description
from w2c_sim_robot.model import build_model, ready_configuration
from w2c_sim_robot.urdf import make_urdf, robots_directory


@pytest.fixture(scope="module")
def description() -> RobotDescription:
    return make_description()


@pytest.fixture(scope="module")
def reference(description: RobotDescription) -> pin.Model:
    """Return the controller's model: loaded from the string alone, without access to a mesh."""
    return pin.buildModelFromXML(description.urdf, pin.JointModelFreeFlyer())


@pytest.fixture(scope="module")
def simulated() -> mujoco.MjModel:
    return build_model()


def pinocchio_configuration(
    reference: pin.Model, description: RobotDescription, world_from_base: Array
) -> Array:
    """Return Pinocchio's configuration of the ready posture."""
    q: Array = pin.neutral(reference)
    q[:3] = world_from_base[:3]
    q[3:7] = np.roll(world_from_base[3:], -1)
    for joint, angle in zip(description.joints, description.initial_position, strict=True):
        q[reference.joints[reference.getJointId(joint.name)].idx_q] = angle
    return q


def test_the_actuated_joints_are_the_controllers_25_and_the_head(
    description: RobotDescription, reference: pin.Model
) -> None:
    names = [joint.name for joint in description.joints]
    assert len(names) == 27
    assert names[-2:] == ["head_1_joint", "head_2_joint"]
    assert set(reference.names) - {"universe", "root_joint"} == set(names)


def test_hand_frames_are_where_the_reference_model_has_them(reference: pin.Model) -> None:
    right = reference.frames[reference.getFrameId("right_hand_frame")]
    left = reference.frames[reference.getFrameId("left_hand_frame")]
    assert reference.names[right.parentJoint] == "arm_right_4_joint"
    assert right.placement.translation == pytest.approx([-0.02, 0.0, -0.3643])
    assert reference.names[left.parentJoint] == "arm_left_7_joint"
    assert left.placement.translation == pytest.approx([0.0, 0.0, -0.2425])


def test_every_frame_of_the_description_exists(
    description: RobotDescription, reference: pin.Model, simulated: mujoco.MjModel
) -> None:
    frames = (*description.sole_frames, *description.hand_frames, description.camera_frame)
    for name in frames:
        assert reference.existFrame(name), name
        assert simulated.body(name).name == name


def test_pinocchio_and_mujoco_agree_on_masses_frames_and_centre_of_mass(
    description: RobotDescription, reference: pin.Model, simulated: mujoco.MjModel
) -> None:
    configuration = ready_configuration(simulated)
    base = simulated.joint("base").qposadr[0]
    q = pinocchio_configuration(reference, description, configuration[base : base + 7])
    kinematics = reference.createData()
    pin.framesForwardKinematics(reference, kinematics, q)
    physics = mujoco.MjData(simulated)
    physics.qpos[:] = configuration
    mujoco.mj_forward(simulated, physics)

    assert simulated.body_mass.sum() == pytest.approx(pin.computeTotalMass(reference), abs=1e-9)
    assert physics.subtree_com[0] == pytest.approx(
        pin.centerOfMass(reference, kinematics, q), abs=1e-9
    )
    frames = (*description.sole_frames, *description.hand_frames, description.camera_frame)
    for name in frames:
        placement = kinematics.oMf[reference.getFrameId(name)]
        assert physics.body(name).xpos == pytest.approx(placement.translation, abs=1e-9)
        assert physics.body(name).xmat.reshape(3, 3) == pytest.approx(placement.rotation, abs=1e-9)


def test_both_models_have_the_same_inertia_beside_the_rotors(
    description: RobotDescription, reference: pin.Model, simulated: mujoco.MjModel
) -> None:
    """The diagonal of the joint-space inertia: a wrong link inertia shows up here."""
    configuration = ready_configuration(simulated)
    base = simulated.joint("base").qposadr[0]
    q = pinocchio_configuration(reference, description, configuration[base : base + 7])
    expected = pin.crba(reference, reference.createData(), q)
    physics = mujoco.MjData(simulated)
    physics.qpos[:] = configuration
    mujoco.mj_forward(simulated, physics)
    inertia = np.zeros((simulated.nv, simulated.nv))
    mujoco.mj_fullM(simulated, physics, inertia)
    for joint in description.joints:
        row = simulated.joint(joint.name).dofadr[0]
        column = reference.joints[reference.getJointId(joint.name)].idx_v
        assert inertia[row, row] - simulated.dof_armature[row] == pytest.approx(
            expected[column, column], abs=1e-9
        )


def test_actuators_have_the_described_stiffness_and_efforts(
    description: RobotDescription, simulated: mujoco.MjModel
) -> None:
    for joint in description.joints:
        assert simulated.actuator(joint.name).gainprm[0] == joint.stiffness
        limit = simulated.jnt_actfrcrange[simulated.joint(joint.name).id]
        assert limit.tolist() == [-joint.effort_limit, joint.effort_limit]
    by_name = {joint.name: joint for joint in description.joints}
    assert by_name["leg_left_4_joint"].effort_limit == 400.0
    assert by_name["arm_right_4_joint"].effort_limit == 70.0
    assert by_name["torso_2_joint"].stiffness == 10000.0


def test_the_robot_starts_inside_its_limits(description: RobotDescription) -> None:
    limits = joint_limits(description)
    assert (limits[:, 0] <= description.initial_position).all()
    assert (description.initial_position <= limits[:, 1]).all()


def test_nothing_of_this_machine_is_in_the_description(description: RobotDescription) -> None:
    assert str(robots_directory()) not in description.urdf
    assert str(Path.home()) not in description.urdf


def test_a_missing_wheel_is_a_clear_error(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"pip install .*sim-robot"):
        robots_directory([str(tmp_path)])


def test_another_robot_in_the_place_of_talos_is_a_clear_error(tmp_path: Path) -> None:
    model = tmp_path / "talos_data/robots/talos_reduced.urdf"
    model.parent.mkdir(parents=True)
    model.write_text("<robot name='other'><link name='base_link'/></robot>")
    with pytest.raises(ConfigError, match="arm_right_6_joint"):
        make_urdf(tmp_path)
    model.write_text("<robot")
    with pytest.raises(ConfigError, match="cannot be read"):
        make_urdf(tmp_path)


def test_head_shell_has_a_group_of_its_own(simulated: mujoco.MjModel) -> None:
    """What the head camera must not draw: the visual shapes of the head, and nothing else."""
    hidden = {
        simulated.body(simulated.geom_bodyid[index]).name
        for index in np.flatnonzero(simulated.geom_group == 2)
    }
    assert hidden == {"head_1_link", "head_2_link"}
    assert talos.CAMERA_FRAME not in hidden
