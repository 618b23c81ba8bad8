"""Perception takes the world of a controller that has been there longer."""

import numpy as np
import pytest

from support.perceiving import DESCRIPTION, READY, TICK_NS, Rig, frame, perceiving
from w2c import topics
from w2c.errors import RefusedError
from w2c.geometry import inverse, quaternion_from_rotation
from w2c.messages import Array, CameraView, ControllerStatus, LiftRequest
from w2c.stance import midway
from w2c_perception.kinematics import CameraKinematics

SOLES = np.array([[0.0, y, 0.0, 0.0, 0.0, 0.0, 1.0] for y in (0.085, -0.085)])
STEPPED = READY.copy()
STEPPED[:6] += [0.1, 0.0, -0.3, 0.3, 0.0, 0.0]  # the left foot forward, and turned


def status(
    tick: int, soles: Array | None, in_contact: tuple[bool, bool] = (True, True)
) -> ControllerStatus:
    """Return what a controller tells whose feet are (2, 7) at these poses."""
    return ControllerStatus(
        stamp_ns=tick * TICK_NS,
        tick=tick,
        phase="hold",
        in_contact=(*in_contact, False, False),
        desired_forces=np.zeros((4, 3)),
        end_effector_positions=np.zeros((4, 3)),
        loads=np.zeros(4),
        solver_failures=0,
        lateness_us={},
        tick_us={},
        soles=soles,
    )


def step(rig: Rig) -> tuple[CameraView, Array]:
    """Let a robot step, before the eyes of perception. Returns its view then, and its soles."""
    kinematics = CameraKinematics(DESCRIPTION)
    rig.see(1000, frame(1000 * TICK_NS))
    rig.see(2000, frame(2000 * TICK_NS), STEPPED, (0.0, 900.0))
    after = rig.see(3000, frame(3000 * TICK_NS), STEPPED)
    stepped = kinematics.camera_pose(STEPPED).world_from_camera
    base_from_camera = midway(*kinematics.soles(STEPPED)) @ stepped
    world_from_base = after.world_from_camera @ inverse(base_from_camera)
    soles = [world_from_base @ sole for sole in kinematics.soles(STEPPED)]
    return after, np.stack(
        [np.hstack([sole[:3, 3], quaternion_from_rotation(sole[:3, :3])]) for sole in soles]
    )


def test_perception_that_starts_after_a_step_begins_in_the_world_of_the_controller(
    rig: Rig,
) -> None:
    before, soles = step(rig)
    alone = CameraKinematics(DESCRIPTION).camera_pose(STEPPED).world_from_camera
    assert np.abs(alone - before.world_from_camera).max() > 0.02

    with perceiving() as restarted:
        controller = restarted.hub.connect("controller")
        controller.publish(topics.CONTROLLER_STATUS, status(3100, soles))
        after = restarted.see(3110, frame(3110 * TICK_NS), STEPPED)

    assert after.world_from_camera == pytest.approx(before.world_from_camera, abs=1e-9)


def test_pictures_of_a_world_of_its_own_are_forgotten_for_that_of_a_controller(rig: Rig) -> None:
    """A controller that comes back later than perception, with what it remembers of the steps."""
    rig.see(1000, frame(1000 * TICK_NS))
    soles = SOLES + np.array([0.3, 0, 0, 0, 0, 0, 0])
    controller = rig.hub.connect("controller")
    controller.publish(topics.CONTROLLER_STATUS, status(1050, None))
    controller.publish(topics.CONTROLLER_STATUS, status(1050, soles))
    after = rig.see(1100, frame(1100 * TICK_NS))

    alone = CameraKinematics(DESCRIPTION).camera_pose(READY).world_from_camera
    assert after.world_from_camera[:3, 3] == pytest.approx(alone[:3, 3] + [0.3, 0, 0], abs=2e-3)
    with pytest.raises(RefusedError, match="there are 1"):
        rig.operator.call(topics.LIFT, LiftRequest(u=1.0, v=1.0, frame_stamp_ns=1000 * TICK_NS))


def test_a_picture_waits_for_a_controller_that_is_there_but_has_not_spoken() -> None:
    with perceiving() as rig:
        controller = rig.hub.connect("controller")
        views = rig.operator.queue(topics.CAMERA_VIEW)
        rig.tell_until_described(100)
        rig.camera.publish(topics.CAMERA_FRAME, frame(100 * TICK_NS))
        rig.tell(range(101, 141, 5), (450.0, 450.0))
        assert views.receive(0.1) is None
        controller.publish(topics.CONTROLLER_STATUS, status(140, SOLES))
        rig.tell(range(141, 146), (450.0, 450.0))
        assert views.receive(20.0) is not None


def test_poses_that_are_none_are_counted(rig: Rig) -> None:
    rig.see(1000, frame(1000 * TICK_NS))
    controller = rig.hub.connect("controller")
    controller.publish(topics.CONTROLLER_STATUS, status(1050, np.zeros((2, 7))))
    controller.close()
    rig.see(1100, frame(1100 * TICK_NS))

    assert rig.perception.counters.get("status of the controller refused", 0) > 0


@pytest.mark.parametrize(
    ("tick", "in_contact"), [(2000, (True, True)), (3090, (False, True)), (9000, (True, True))]
)
def test_a_status_that_says_nothing_of_the_feet_now_is_not_believed(
    rig: Rig, tick: int, in_contact: tuple[bool, bool]
) -> None:
    """Of a controller that died, of one whose foot is in the air, of before a restart."""
    soles = np.tile([0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], (2, 1))
    controller = rig.hub.connect("controller")
    before = rig.see(3000, frame(3000 * TICK_NS))
    controller.publish(topics.CONTROLLER_STATUS, status(tick, soles, in_contact))
    controller.close()
    after = rig.see(3110, frame(3110 * TICK_NS))

    assert after.world_from_camera == pytest.approx(before.world_from_camera, abs=1e-9)
