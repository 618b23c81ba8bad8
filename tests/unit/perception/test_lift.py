"""Lift on made-up depth: planes, edges, holes, sky, and an error bound that holds."""

import numpy as np
import pytest

from support.surfaces import (
    CAMERA,
    HEIGHT,
    TABLE,
    TABLE_HEIGHT,
    WIDTH,
    WORLD_FROM_CAMERA,
    ball,
    book,
    depth_of,
    in_world,
    quantised,
)
from w2c.errors import RefusedError
from w2c.geometry import unit
from w2c_perception.lift import lift


@pytest.mark.parametrize("tilt", [0.0, 0.2, 0.5])
def test_a_plane_is_found_to_a_fraction_of_a_millimetre(tilt: float) -> None:
    normal = unit([-np.sin(tilt), 0.1, np.cos(tilt)])
    anchor = np.array([0.8, 0.0, TABLE_HEIGHT])
    depth = quantised(depth_of(normal, anchor))

    surface = lift(depth, CAMERA, WORLD_FROM_CAMERA, 150.3, 130.8)

    assert abs((surface.point - anchor) @ normal) < 2e-4
    # The point is on the very ray of the pixel, not of the pixel's centre.
    from_camera = unit(surface.point - WORLD_FROM_CAMERA[:3, 3])
    assert from_camera == pytest.approx(
        unit(WORLD_FROM_CAMERA[:3, :3] @ CAMERA.point_from_pixel(150.3, 130.8, 1.0)), abs=1e-9
    )
    assert surface.normal == pytest.approx(normal, abs=5e-3)
    assert surface.slope == pytest.approx(np.arccos(normal[2]), abs=5e-3)
    assert surface.flatness < 2e-4
    assert surface.error_bound < 1e-3


def test_noise_is_averaged_and_is_not_taken_for_roughness() -> None:
    noise = np.random.default_rng(0).normal(0.0, 0.001, TABLE.shape)

    surface = lift(quantised(TABLE + noise), CAMERA, WORLD_FROM_CAMERA, 160.0, 120.0)

    error = abs(surface.point[2] - TABLE_HEIGHT)
    assert error < 5e-4
    assert error < surface.error_bound
    assert surface.flatness < 4e-4


def test_beyond_an_edge_the_other_surface_has_no_say() -> None:
    depth, inside = book()
    rows, columns = np.nonzero(inside)
    column = int(np.median(columns))
    far_edge = int(rows[columns == column].min())

    for row in (far_edge, far_edge + 1, far_edge + 3):
        surface = lift(depth, CAMERA, WORLD_FROM_CAMERA, column + 0.5, row + 0.5)

        assert surface.point[2] == pytest.approx(TABLE_HEIGHT + 0.04, abs=1e-3)
        assert surface.normal[2] > 0.999
        assert surface.extent < 0.03
        assert surface.warning == "", "the shape of the surface is for the verdicts to judge"


def test_just_outside_an_edge_the_surface_in_front_is_meant() -> None:
    depth, inside = book()
    rows, columns = np.nonzero(inside)
    column = int(np.median(columns))
    row = int(rows[columns == column].min()) - 1

    surface = lift(depth, CAMERA, WORLD_FROM_CAMERA, column + 0.5, row + 0.5)

    assert surface.point[2] == pytest.approx(TABLE_HEIGHT + 0.04, abs=1e-3)
    assert "moved to the nearest surface in front" in surface.warning
    # It says that it moved: the bound covers the step from the pixel to the edge.
    true = in_world(column + 0.5, row + 0.5, float(depth[row, column]))
    assert surface.error_bound > 0.002
    assert np.linalg.norm(surface.point[:2] - true[:2]) < 0.1


def test_a_step_never_gives_the_mean_of_two_surfaces() -> None:
    depth, inside = book(height=0.3)
    heights = []
    rows, columns = np.nonzero(inside)
    for column in range(columns.min() - 6, columns.max() + 6, 3):
        surface = lift(depth, CAMERA, WORLD_FROM_CAMERA, column + 0.5, float(np.median(rows)))
        heights.append(surface.point[2])

    off = np.min(np.abs(np.subtract.outer(heights, [TABLE_HEIGHT, TABLE_HEIGHT + 0.3])), axis=1)
    assert off.max() < 2e-3


def test_the_extent_is_the_distance_to_the_edge() -> None:
    depth, inside = book()
    rows, columns = np.nonzero(inside)

    surface = lift(depth, CAMERA, WORLD_FROM_CAMERA, columns.mean(), rows.mean())

    assert 0.08 <= surface.extent <= 0.11
    assert surface.warning == ""


def test_the_extent_ends_where_the_picture_does() -> None:
    surface = lift(quantised(TABLE), CAMERA, WORLD_FROM_CAMERA, 310.0, 120.0)

    assert surface.extent < 0.06


def test_a_small_hole_is_bridged() -> None:
    depth = quantised(TABLE)
    depth[119:121, 159:161] = 0.0

    surface = lift(depth, CAMERA, WORLD_FROM_CAMERA, 160.0, 120.0)

    assert surface.point[2] == pytest.approx(TABLE_HEIGHT, abs=5e-4)


def test_scattered_wrong_depths_do_not_matter() -> None:
    rng = np.random.default_rng(1)
    depth = quantised(TABLE)
    wrong = rng.random(depth.shape) < 0.1
    wrong[118:123, 158:163] = False
    depth[wrong] = rng.uniform(0.3, 5.0, wrong.sum()).astype(np.float32)

    surface = lift(depth, CAMERA, WORLD_FROM_CAMERA, 160.0, 120.0)

    assert surface.point[2] == pytest.approx(TABLE_HEIGHT, abs=1e-3)
    assert surface.normal[2] > 0.999


def test_a_curved_surface_is_touched_where_it_was_measured_and_called_curved() -> None:
    """A ball of 6 cm: the plane is its tangent, the point is on it, the bound admits the doubt."""
    depth = ball(np.array([0.0, 0.0, 1.0]), 0.06)

    surface = lift(quantised(depth), CAMERA, WORLD_FROM_CAMERA, 160.0, 120.0)

    true = in_world(160.0, 120.0, 0.94)
    error = float(np.linalg.norm(surface.point - true))
    assert error <= surface.error_bound
    assert error < 0.004
    assert surface.flatness > 0.001
    assert surface.extent < 0.04


def test_the_bound_covers_the_error_on_rough_ground() -> None:
    rng = np.random.default_rng(2)
    broken = 0
    for trial in range(60):
        noise = rng.normal(0.0, rng.uniform(0.0, 0.002), TABLE.shape)
        u, v = rng.uniform(60, 260), rng.uniform(60, 200)
        surface = lift(quantised(TABLE + noise), CAMERA, WORLD_FROM_CAMERA, u, v)
        broken += abs(surface.point[2] - TABLE_HEIGHT) > surface.error_bound
        assert trial >= 0
    assert broken == 0


def test_a_picture_that_moved_between_colour_and_depth_widens_the_bound() -> None:
    depth, inside = book(height=0.3)
    rows, columns = np.nonzero(inside)
    u, v = columns.max() - 6.0, float(np.median(rows))

    still = lift(depth, CAMERA, WORLD_FROM_CAMERA, u, v)
    moving = lift(depth, CAMERA, WORLD_FROM_CAMERA, u, v, blur=3.0)
    at_edge = lift(depth, CAMERA, WORLD_FROM_CAMERA, u, v, blur=12.0)

    assert still.error_bound < 0.002
    assert 0.005 < moving.error_bound < 0.03  # three pixels on the box
    assert at_edge.error_bound > 0.25  # the pixel may have shown the table
    assert "the camera moved by 12 px" in at_edge.warning


@pytest.mark.parametrize("blur", [17.0, float("nan")])
def test_a_camera_that_moved_too_fast_is_refused(blur: float) -> None:
    with pytest.raises(RefusedError, match="taken at rest"):
        lift(quantised(TABLE), CAMERA, WORLD_FROM_CAMERA, 160.0, 120.0, blur=blur)


def test_the_same_picture_gives_the_same_answer() -> None:
    depth, _ = book()

    first = lift(depth, CAMERA, WORLD_FROM_CAMERA, 170.0, 110.0)
    second = lift(depth, CAMERA, WORLD_FROM_CAMERA, 170.0, 110.0)

    assert first.point.tolist() == second.point.tolist()
    assert first.error_bound == second.error_bound


def test_the_sky_is_refused() -> None:
    depth = quantised(TABLE)
    depth[:100] = 0.0

    with pytest.raises(RefusedError, match=r"no depth at pixel \(160, 50\): sky"):
        lift(depth, CAMERA, WORLD_FROM_CAMERA, 160.0, 50.0)


@pytest.mark.parametrize("pixel", [(-1.0, 5.0), (5.0, 240.0), (float("nan"), 5.0), (1e9, 1e9)])
def test_a_pixel_outside_of_the_picture_is_refused(pixel: tuple[float, float]) -> None:
    with pytest.raises(RefusedError, match="320x240"):
        lift(quantised(TABLE), CAMERA, WORLD_FROM_CAMERA, *pixel)


def test_a_speck_is_no_surface() -> None:
    depth = np.zeros((HEIGHT, WIDTH), np.float32)
    depth[120, 158:164] = 1.0

    with pytest.raises(RefusedError, match=r"plane needs|on a line"):
        lift(depth, CAMERA, WORLD_FROM_CAMERA, 160.5, 120.5)


def test_a_corner_pixel_works() -> None:
    surface = lift(quantised(TABLE), CAMERA, WORLD_FROM_CAMERA, 0.0, 239.9)

    assert surface.point[2] == pytest.approx(TABLE_HEIGHT, abs=5e-4)
    assert surface.extent == 0.0
