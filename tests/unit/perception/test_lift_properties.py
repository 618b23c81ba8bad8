"""Lift on any plane, step, rod, ball and hole, with noise: close, honest, or refused."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from support.surfaces import (
    CAMERA,
    HEIGHT,
    TABLE,
    WIDTH,
    WORLD_FROM_CAMERA,
    all_rays,
    ball,
    depth_of,
    in_world,
    noisy,
    quantised,
    upright_rod,
)
from w2c.errors import RefusedError
from w2c.geometry import unit
from w2c_perception.growing import grow
from w2c_perception.lift import Surface, lift
from w2c_perception.window import find_seed

SOME = settings(max_examples=12, derandomize=True)
MIDDLE = (160.5, 120.5)


def at(depth: np.ndarray, u: float = MIDDLE[0], v: float = MIDDLE[1]) -> Surface:
    return lift(depth.astype(np.float32), CAMERA, WORLD_FROM_CAMERA, u, v)


def depth_in_camera(surface: Surface) -> float:
    """Return the z-depth of the answer [m]."""
    return float((np.linalg.inv(WORLD_FROM_CAMERA) @ [*surface.point, 1.0])[2])


@SOME
@given(
    tilt=st.floats(-0.6, 0.3),
    roll=st.floats(-0.3, 0.3),
    sigma=st.floats(0.0, 0.004),
    u=st.floats(60.0, 260.0),
    v=st.floats(60.0, 180.0),
)
def test_any_plane_is_found_within_its_bound(
    tilt: float, roll: float, sigma: float, u: float, v: float
) -> None:
    normal = unit([np.sin(tilt), np.sin(roll), 1.0])
    anchor = np.array([0.8, 0.0, 0.8])
    depth = noisy(depth_of(normal, anchor), sigma)

    surface = at(depth, u, v)

    error = abs(float((surface.point - anchor) @ normal))
    assert error <= surface.error_bound
    assert error <= 0.0005 + 0.5 * sigma
    assert np.degrees(np.arccos(min(1.0, float(surface.normal @ normal)))) <= 0.3 + 2500.0 * sigma
    assert surface.flatness <= 0.0005 + 0.3 * sigma


@SOME
@given(
    column=st.floats(100.0, 220.0),
    step=st.floats(0.05, 1.0),
    sigma=st.floats(0.0, 0.003),
)
def test_at_a_step_the_answer_is_one_surface_or_the_other(
    column: float, step: float, sigma: float
) -> None:
    columns = np.mgrid[0:HEIGHT, 0:WIDTH][1] + 0.5
    truth = np.where(columns < 160.0, 1.0, 1.0 + step)

    surface = at(noisy(truth, sigma), column)

    found = depth_in_camera(surface)
    assert min(abs(found - 1.0), abs(found - 1.0 - step)) <= 0.002 + 2.0 * sigma
    if column < 162.0:
        assert abs(found - 1.0) <= 0.002 + 2.0 * sigma  # the surface in front


@SOME
@given(width=st.floats(5.0, 30.0), sigma=st.floats(0.0, 0.002), aside=st.floats(-0.4, 0.4))
def test_a_thin_rod_is_touched_not_the_wall_behind_it(
    width: float, sigma: float, aside: float
) -> None:
    depth = np.minimum(upright_rod(160.0, width, 0.7), 1.5)

    surface = at(noisy(depth, sigma), 160.0 + aside * width)

    assert depth_in_camera(surface) == pytest.approx(0.7, abs=0.001 + 2.0 * sigma)
    assert surface.extent <= 0.02 + 0.5 * width * 0.7 / CAMERA.fx
    assert surface.edge_distance <= 0.012 + 0.5 * width * 0.7 / CAMERA.fx


@SOME
@given(radius=st.floats(0.03, 0.3), sigma=st.floats(0.0, 0.002))
@example(radius=0.03125, sigma=0.00107)
def test_a_ball_is_touched_on_its_skin(radius: float, sigma: float) -> None:
    centre = np.array([0.02, 0.01, 0.8 + radius])
    depth = np.minimum(ball(centre, radius), 3.0)
    u, v = CAMERA.pixel_from_point(np.array([0.02, 0.01, 0.8]))

    surface = at(noisy(depth, sigma), u, v)

    ray = unit(CAMERA.point_from_pixel(u, v, 1.0))
    along = float(ray @ centre)
    true = ray * (along - np.sqrt(along**2 - centre @ centre + radius**2))
    error = float(np.linalg.norm(surface.point - in_world(u, v, true[2])))
    assert error <= max(surface.error_bound, 0.001)
    normal = WORLD_FROM_CAMERA[:3, :3] @ unit(true - centre)
    assert np.degrees(np.arccos(min(1.0, float(surface.normal @ normal)))) < 12.0


@SOME
@given(holes=st.floats(0.0, 0.2), sigma=st.floats(0.0, 0.003), seed=st.integers(0, 1000))
@example(holes=0.125, sigma=0.0, seed=502)
@example(holes=0.2, sigma=0.0, seed=518)
def test_scattered_holes_change_nothing(holes: float, sigma: float, seed: int) -> None:
    depth = noisy(TABLE, sigma, seed)
    rng = np.random.default_rng(seed)
    depth[rng.random(depth.shape) < holes] = 0.0

    surface = at(depth)

    assert abs(surface.point[2] - 0.8) <= min(surface.error_bound, 0.0005 + 0.7 * sigma)
    assert surface.extent > 0.05
    assert surface.edge_distance > 0.2


@pytest.mark.parametrize(("radius", "answered"), [(1, True), (3, True), (6, False), (20, False)])
def test_a_hole_is_bridged_as_far_as_it_can_be_known(radius: int, answered: bool) -> None:
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    depth = noisy(TABLE, 0.002)
    depth[np.hypot(columns - MIDDLE[0], rows - MIDDLE[1]) <= radius] = 0.0

    if answered:
        surface = at(depth)
        assert abs(surface.point[2] - 0.8) <= min(surface.error_bound, 0.001)
    else:
        with pytest.raises(RefusedError, match="no depth at pixel"):
            at(depth)


def test_a_wide_hole_beside_an_edge_is_not_guessed() -> None:
    """Three pixels beside the end of a board, over nothing: the board may end anywhere there."""
    columns = np.mgrid[0:HEIGHT, 0:WIDTH][1]
    depth = np.where(columns < 158, 1.0, 0.0)

    with pytest.raises(RefusedError, match="an edge"):
        at(depth)


def test_where_the_pixel_may_show_either_of_two_surfaces_the_bound_says_so() -> None:
    columns = np.mgrid[0:HEIGHT, 0:WIDTH][1]
    depth = np.where(columns < 160, 1.0, 1.3)
    depth[:, 158:162] = 0.0

    surface = at(depth, 159.5)

    assert depth_in_camera(surface) == pytest.approx(1.0, abs=1e-3)
    assert surface.error_bound >= 0.3
    assert "moved to the nearest surface in front" in surface.warning


def test_a_crease_bends_nothing() -> None:
    """A wall that rises from a table: beside the fold each keeps its own slope."""
    table = depth_of(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 0.8]))
    wall = depth_of(np.array([-1.0, 0.0, 0.0]), np.array([0.9, 0.0, 0.0]))
    depth = noisy(np.minimum(table, wall), 0.002)
    fold = int(np.argmax(table[:, 160] <= wall[:, 160]))

    on_table, on_wall = at(depth, 160.0, fold + 8.5), at(depth, 160.0, fold - 8.5)

    assert on_table.normal[2] > np.cos(np.radians(5.0))
    assert on_wall.normal[0] < -np.cos(np.radians(5.0))
    assert abs(on_table.point[2] - 0.8) <= on_table.error_bound
    assert abs(on_wall.point[0] - 0.9) <= on_wall.error_bound


def test_noise_alone_is_no_surface() -> None:
    rng = np.random.default_rng(0)
    depth = rng.uniform(0.3, 5.0, (HEIGHT, WIDTH))

    refused = 0
    for u in np.linspace(30, 290, 20):
        try:
            surface = at(depth, float(u))
            assert surface.extent < 0.05
        except RefusedError:
            refused += 1
    assert refused >= 10


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0])
def test_depth_that_is_no_number_is_no_depth(bad: float) -> None:
    depth = quantised(TABLE)
    depth[118:123, 158:163] = bad

    surface = at(np.where(np.isfinite(depth) & (depth > 0), depth, 0.0))

    assert surface.point[2] == pytest.approx(0.8, abs=1e-3)


def test_the_edge_is_where_one_sees_past_the_surface_not_where_something_stands() -> None:
    board = quantised(TABLE)
    points = all_rays() * TABLE[..., None]
    world = points @ WORLD_FROM_CAMERA[:3, :3].T + WORLD_FROM_CAMERA[:3, 3]
    ended, covered = board.copy(), board.copy()
    beyond = world[..., 1] > 0.08  # to the left
    ended[beyond] = 2.5
    covered[beyond] -= 0.05

    end, cover = at(ended), at(covered)

    assert end.edge_distance == pytest.approx(0.08, abs=0.012)
    assert cover.edge_distance == 0.25
    assert end.extent == pytest.approx(cover.extent, abs=0.011)
    assert 0.06 <= end.extent <= 0.1


def test_a_piece_does_not_grow_over_what_is_mostly_something_else() -> None:
    depth = noisy(np.minimum(upright_rod(160.5, 12.0, 0.7), 0.73), 0.001)
    seed = find_seed(depth, *MIDDLE, CAMERA.fx, 0.001)

    on_rod = grow(depth, seed, CAMERA.fx, 0.05, 0.001)
    wall = noisy(np.full((HEIGHT, WIDTH), 0.73), 0.001)
    on_wall = grow(wall, find_seed(wall, *MIDDLE, CAMERA.fx, 0.001), CAMERA.fx, 0.05, 0.001)

    assert on_rod.radius <= 12.0
    assert on_wall.radius == pytest.approx(0.05 * CAMERA.fx / 0.73, rel=0.01)
