"""Heights from depth: a box on a table, what it hides, and the robot's own arm cut out."""

import numpy as np

from fakes.table_picture import CAMERA, HEIGHT, WIDTH, camera_pose
from support.surfaces import Depth
from w2c.messages import Array
from w2c_perception.heights import ARM_RADIUS, Area, Heights, height_field

TABLE = 0.75
BOX = (np.array([0.55, -0.10, TABLE]), np.array([0.65, 0.10, 1.0]))
"""Lower and upper corner [m]"""
NO_ARMS = np.zeros((0, 2, 3))
POSE = camera_pose()


def _picture(*boxes: tuple[Array, Array]) -> Depth:
    """Return the depth (h, w) of a table without end and boxes, by casting rays."""
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH].astype(np.float64)
    in_camera = CAMERA.rays(columns + 0.5, rows + 0.5)
    direction = in_camera @ POSE[:3, :3].T
    origin = POSE[:3, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        nearest = np.where(direction[..., 2] < 0, (TABLE - origin[2]) / direction[..., 2], np.inf)
        for low, high in boxes:
            enter = np.minimum((low - origin) / direction, (high - origin) / direction).max(axis=-1)
            leave = np.maximum((low - origin) / direction, (high - origin) / direction).min(axis=-1)
            hit = (enter < leave) & (enter > 0)
            nearest = np.where(hit, np.minimum(nearest, enter), nearest)
    return np.where(np.isfinite(nearest), nearest, 0.0).astype(np.float32)


def _at(heights: Heights, x: float, y: float) -> float:
    area = Area()
    row, column = int((x - area.x[0]) / area.cell), int((y - area.y[0]) / area.cell)
    return float(heights[row, column])


def test_a_box_stands_out_of_the_table() -> None:
    heights = height_field(_picture(BOX), CAMERA, POSE, NO_ARMS)
    assert abs(_at(heights, 0.60, 0.0) - 1.0) < 0.002
    assert abs(_at(heights, 0.45, 0.3) - TABLE) < 0.002
    seen = heights[np.isfinite(heights)]
    assert seen.max() < 1.002
    assert seen.min() > TABLE - 0.002


def test_the_area_of_a_box_is_that_of_its_top() -> None:
    heights = height_field(_picture(BOX), CAMERA, POSE, NO_ARMS)
    high = (heights > 0.99).sum() * Area().cell ** 2
    assert abs(high - 0.1 * 0.2) < 0.006


def test_what_a_box_hides_is_unseen_not_low() -> None:
    heights = height_field(_picture(BOX), CAMERA, POSE, NO_ARMS)
    assert np.isnan(_at(heights, 0.72, 0.0))
    assert np.isfinite(_at(heights, 0.72, 0.3))


def test_without_depth_nothing_is_seen() -> None:
    heights = height_field(np.zeros((HEIGHT, WIDTH), np.float32), CAMERA, POSE, NO_ARMS)
    assert heights.shape == Area().shape
    assert np.isnan(heights).all()


def test_the_arm_is_cut_out_and_what_it_hides_is_unseen() -> None:
    arm = (np.array([0.3, 0.2, 1.0]), np.array([0.6, 0.26, 1.06]))
    picture = _picture(BOX, arm)
    bones = np.array([[[0.3, 0.23, 1.03], [0.6, 0.23, 1.03]]])
    with_arm = height_field(picture, CAMERA, POSE, NO_ARMS)
    without = height_field(picture, CAMERA, POSE, bones)
    assert _at(with_arm, 0.45, 0.23) > 1.05
    assert not _at(without, 0.45, 0.23) > TABLE + 0.002
    assert abs(_at(without, 0.60, 0.0) - 1.0) < 0.002
    assert np.nanmax(without) < 1.002


def test_an_object_that_touches_no_arm_stays() -> None:
    bones = np.array([[[0.6, 0.10 + ARM_RADIUS + 0.03, 0.9], [0.6, 0.6, 0.9]]])
    heights = height_field(_picture(BOX), CAMERA, POSE, bones)
    assert abs(_at(heights, 0.60, 0.08) - 1.0) < 0.002


def test_a_single_stray_point_makes_no_cell() -> None:
    depth = np.zeros((HEIGHT, WIDTH), np.float32)
    depth[300, 640] = 0.9
    assert np.isnan(height_field(depth, CAMERA, POSE, NO_ARMS)).all()
