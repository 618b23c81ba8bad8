"""Where the camera is, from joint angles: against the simulator, and for descriptions that lie."""

import msgspec
import mujoco
import numpy as np
import pytest

from w2c.errors import GeometryError
from w2c.geometry import base_from_midfeet, inverse, transform
from w2c.messages import Array, RobotDescription
from w2c.stance import Stance, both_feet
from w2c_perception.kinematics import CameraKinematics
from w2c_sim_robot import talos
from w2c_sim_robot.description import make_description
from w2c_sim_robot.model import HEAD_CAMERA, build_model
from w2c_sim_robot.physics import Simulator


@pytest.fixture(scope="module")
def description() -> RobotDescription:
    return make_description()


@pytest.mark.parametrize("seed", range(4))
def test_the_camera_is_where_the_simulator_has_it(description: RobotDescription, seed: int) -> None:
    """Any posture, the base anywhere: relative to the feet both models agree."""
    rng = np.random.default_rng(seed)
    model = build_model()
    data = mujoco.MjData(model)
    position = talos.ready_position() + rng.uniform(-0.15, 0.15, len(talos.ACTUATED))
    for name, angle in zip(talos.ACTUATED, position, strict=True):
        data.joint(name).qpos = angle
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    soles = [
        transform(data.body(name).xmat.reshape(3, 3), data.body(name).xpos)
        for name in talos.SOLE_FRAMES
    ]
    camera = data.camera(HEAD_CAMERA)
    optical = camera.xmat.reshape(3, 3) @ np.diag([1.0, -1.0, -1.0])
    expected = inverse(base_from_midfeet(*soles)) @ transform(optical, camera.xpos)

    actual = CameraKinematics(description).camera_pose(position).world_from_camera

    assert actual == pytest.approx(expected, abs=1e-9)


def test_standing_ready_the_camera_looks_ahead_and_down(description: RobotDescription) -> None:
    pose = CameraKinematics(description).camera_pose(talos.ready_position()).world_from_camera

    forward = pose[:3, 2]
    assert 1.4 < pose[2, 3] < 1.8
    assert forward[0] > 0.5
    assert forward[2] < -0.5
    assert pose[:3, 0] == pytest.approx([0, -1, 0], abs=1e-3)  # the picture's right


@pytest.mark.parametrize("angles", [np.zeros(3), np.full(len(talos.ACTUATED), np.nan)])
def test_angles_that_do_not_fit_are_refused(description: RobotDescription, angles: Array) -> None:
    with pytest.raises(GeometryError, match="expected finite"):
        CameraKinematics(description).camera_pose(angles)


@pytest.mark.parametrize(
    ("field", "value", "complaint"),
    [
        ("urdf", "not a robot", "URDF cannot be read"),
        ("camera_frame", "third_eye", "no frame 'third_eye'"),
        ("sole_frames", ("left_sole_link", "wheel"), "no frame 'wheel'"),
    ],
)
def test_a_description_that_does_not_fit_its_urdf_is_refused(
    description: RobotDescription, field: str, value: object, complaint: str
) -> None:
    broken = msgspec.structs.replace(description, **{field: value})

    with pytest.raises(GeometryError, match=complaint):
        CameraKinematics(broken)


def test_the_bones_of_the_arms_end_where_the_hands_are(description: RobotDescription) -> None:
    truth = Simulator(build_model(None, visuals=False), description).truth()

    bones = CameraKinematics(description).camera_pose(talos.ready_position()).arms

    assert bones.shape == (11, 2, 3)  # seven joints of the left arm, four of the right
    assert bones[6, 1] == pytest.approx(truth.end_effector_positions[2], abs=1e-3)
    assert bones[10, 1] == pytest.approx(truth.end_effector_positions[3], abs=1e-3)
    assert bones[0, 0][2] > 1.2
    np.testing.assert_allclose(bones[1:7, 0], bones[:6, 1])


def standing(rng: np.random.Generator) -> Array:
    """Return joint angles of a robot whose soles are level: both legs bent alike, the rest free."""
    position = talos.ready_position() + rng.uniform(-0.2, 0.2, len(talos.ACTUATED))
    position[:12] = talos.ready_position()[:12] + np.tile(
        [0, 0, -0.1, 0.2, -0.1, 0] * rng.uniform(0.0, 1.0, 1), 2
    )
    return position


@pytest.mark.parametrize("feet", [(True, True), (True, False), (False, True)])
def test_how_a_point_moves_with_the_joints_agrees_with_differences(
    description: RobotDescription, feet: tuple[bool, bool]
) -> None:
    kinematics = CameraKinematics(description)
    position = standing(np.random.default_rng(3))
    anchors = both_feet(kinematics.soles(position)).anchors
    stance = Stance(feet, anchors, 1)
    pose = kinematics.camera_pose(position, stance)
    in_camera = np.array([0.2, -0.1, 0.9, 1.0])
    step = 1e-6
    expected = np.empty((3, len(position)))
    for joint in range(len(position)):
        change = step * (np.arange(len(position)) == joint)
        ahead, behind = (
            kinematics.camera_pose(position + sign * change, stance).world_from_camera @ in_camera
            for sign in (1.0, -1.0)
        )
        expected[:, joint] = (ahead - behind)[:3] / (2.0 * step)

    actual = pose.point_jacobian((pose.world_from_camera @ in_camera)[:3])

    assert actual == pytest.approx(expected, abs=1e-8)
    assert np.abs(expected).max() > 0.5


def test_the_error_of_a_point_covers_biased_joints(description: RobotDescription) -> None:
    kinematics = CameraKinematics(description)
    rng = np.random.default_rng(4)
    position, bias = standing(rng), np.radians(0.05)
    pose = kinematics.camera_pose(position)
    in_camera = np.array([0.1, 0.1, 0.8, 1.0])
    point = (pose.world_from_camera @ in_camera)[:3]
    off = [
        np.linalg.norm(
            (
                kinematics.camera_pose(
                    position + rng.uniform(-bias, bias, position.shape)
                ).world_from_camera
                @ in_camera
            )[:3]
            - point
        )
        for _ in range(200)
    ]

    bound = pose.error(point, bias)

    assert 0.95 <= np.mean(np.array(off) <= bound) <= 1.0
    assert bound < 3.0 * np.median(off)
    assert pose.error(point, 0.0) == 0.0
