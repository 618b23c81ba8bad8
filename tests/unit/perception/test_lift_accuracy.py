"""Lift against the simulator's truth, through the wire format: two millimetres on flat surfaces."""

from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np
import pytest

from w2c.geometry import Intrinsics, Matrix
from w2c.messages import Array, CameraFrame
from w2c_perception.buffer import View
from w2c_perception.kinematics import CameraKinematics
from w2c_perception.lift import Surface, lift
from w2c_sim_robot import talos
from w2c_sim_robot.camera.gl import choose_backend
from w2c_sim_robot.camera.studio import Studio
from w2c_sim_robot.description import make_description
from w2c_sim_robot.model import HEAD_CAMERA, HEAD_SHELL_GROUP, ready_configuration
from w2c_sim_robot.scenes.scenario_a import scenario_a

choose_backend()

LIMIT = 0.002
VISIBLE_GROUPS = np.array([1, 1, 0, 0, 0, 0], np.uint8)


@dataclass
class Rig:
    """One picture of scenario (a), as perception has it, and the simulator behind it."""

    studio: Studio
    frame: CameraFrame
    depth: Array
    body_seen: Array
    """(h, w)"""
    world_from_camera: Matrix
    """By forward kinematics, as perception computes it"""

    def pixels(self, body: str, count: int, margin: int = 4) -> Array:
        """Return (count, 2) pixels (u, v) on a body, `margin` away from its border."""
        seen = (self.body_seen == self.studio.model.body(body).id).astype(np.uint8)
        size = 2 * margin + 1
        windows = np.lib.stride_tricks.sliding_window_view(np.pad(seen, margin), (size, size))
        rows, columns = np.nonzero(windows.all(axis=(2, 3)))
        rng = np.random.default_rng(0)
        chosen = rng.integers(len(rows), size=count)
        return np.column_stack([columns[chosen], rows[chosen]]) + rng.uniform(0, 1, (count, 2))

    def lift(self, u: float, v: float) -> Surface:
        """Return what perception says of a pixel."""
        return lift(self.depth, Intrinsics(*self.frame.intrinsics), self.world_from_camera, u, v)

    def truth(self, u: float, v: float) -> Array:
        """Return (3,) where a ray through the pixel meets the simulator's geometry."""
        camera = self.studio.data.camera(HEAD_CAMERA)
        optical = camera.xmat.reshape(3, 3) @ np.diag([1.0, -1.0, -1.0])
        ray = optical @ Intrinsics(*self.frame.intrinsics).point_from_pixel(u, v, 1.0)
        ray = ray / np.linalg.norm(ray)
        geom = np.array([-1], np.int32)
        distance = mujoco.mj_ray(
            self.studio.model, self.studio.data, camera.xpos, ray, VISIBLE_GROUPS, 1, -1, geom
        )
        return np.asarray(camera.xpos + distance * ray)


@pytest.fixture(scope="module")
def rig() -> Iterator[Rig]:
    studio = Studio(scenario_a())
    position = talos.ready_position()
    studio.pose(ready_configuration(studio.model))
    frame = studio.frame(1)
    pose = CameraKinematics(make_description()).camera_pose(position)
    geoms = studio.renderer.segment(
        studio.data, HEAD_CAMERA, size=(1280, 720), hidden_groups=(HEAD_SHELL_GROUP,)
    )
    bodies = np.append(studio.model.geom_bodyid, -1)[geoms]
    depth = View(frame, pose, np.zeros(len(position))).unpack_depth()[:]
    yield Rig(studio, frame, depth, bodies, pose.world_from_camera)
    studio.close()


@pytest.mark.parametrize("body", ["book", "table"])
def test_flat_surfaces_are_lifted_to_two_millimetres(rig: Rig, body: str) -> None:
    top = rig.studio.data.body(body).xpos[2] + (0.04 if body == "book" else 0.80)
    errors, misses = [], 0
    for u, v in rig.pixels(body, 150):
        truth = rig.truth(u, v)
        if abs(truth[2] - top) > 1e-3:  # the side of the book is another surface
            continue
        surface = rig.lift(u, v)
        error = float(np.linalg.norm(surface.point - truth))
        errors.append(error)
        misses += error > surface.error_bound
        if surface.extent >= 0.01:  # nearer to the groove of a spine its slope is seen too
            assert np.degrees(np.arccos(min(1.0, surface.normal[2]))) < 1.0

    assert len(errors) > 80
    assert max(errors) <= LIMIT
    assert misses == 0


@pytest.mark.parametrize("body", ["cup", "bottle"])
def test_on_curved_things_the_error_stays_within_its_bound(rig: Rig, body: str) -> None:
    """Where the ray meets the same thing: at the rim of a cup it may pass by."""
    errors, bounds = [], []
    for u, v in rig.pixels(body, 120):
        surface = rig.lift(u, v)
        error = float(np.linalg.norm(surface.point - rig.truth(u, v)))
        errors.append(error)
        bounds.append(surface.error_bound)

    assert np.median(errors) < 0.003
    assert np.mean(np.array(errors) > np.array(bounds)) < 0.05


def test_a_hand_can_be_sent_to_the_middle_of_the_book(rig: Rig) -> None:
    book = scenario_a().object("book")
    camera_from_world = np.linalg.inv(rig.world_from_camera)
    in_camera = camera_from_world @ [*book.top_in_world, 1.0]
    u, v = Intrinsics(*rig.frame.intrinsics).pixel_from_point(in_camera[:3])

    surface = rig.lift(u, v)

    assert surface.point == pytest.approx(book.top_in_world, abs=1e-3)
    assert surface.extent > 0.07
    assert surface.flatness < 5e-4
    assert surface.warning == ""
