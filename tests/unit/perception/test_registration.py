"""Depth that was taken at another instant than the colours, by a camera that moved meanwhile."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.surfaces import CAMERA, HEIGHT, WIDTH, WORLD_FROM_CAMERA, Depth, all_rays, quantised
from w2c.errors import RefusedError
from w2c.geometry import Matrix, apply, inverse, transform
from w2c.messages import Array
from w2c_perception.cloud import Box, point_cloud
from w2c_perception.lift import lift
from w2c_perception.registration import find_in_depth, to_colours

TABLE, TOP = 0.8, 0.95
"""Heights of a table, and of the box on it [m]"""
SIDE = 0.12
"""Half of the box' sides; its middle is at x = 0.8"""
SOME = settings(max_examples=10, derandomize=True)


def moved(turn: tuple[float, float], shift: tuple[float, float, float]) -> Matrix:
    """Return depth_from_colours of a camera that turned [rad] (down, sidewards) and moved [m]."""
    (down, aside), c = turn, np.cos
    about_x = np.array(
        [[1, 0, 0], [0, c(down), -np.sin(down)], [0, np.sin(down), c(down)]], dtype=float
    )
    about_y = np.array(
        [[c(aside), 0, np.sin(aside)], [0, 1, 0], [-np.sin(aside), 0, c(aside)]], dtype=float
    )
    return transform(about_x @ about_y, shift)


def seen_from(world_from_camera: Matrix, *, box: bool = True, sigma: float = 0.0) -> Depth:
    """Return the exact depth (h, w) of a box of 15 cm on a table, with noise on top [m]."""
    rays = all_rays() @ world_from_camera[:3, :3].T
    eye = world_from_camera[:3, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        z = (TABLE - eye[2]) / rays[..., 2]
        if box:
            for axis, place in ((0, 0.8 - SIDE), (0, 0.8 + SIDE), (1, -SIDE), (1, SIDE), (2, TOP)):
                side = (place - eye[axis]) / rays[..., axis]
                at = eye + side[..., None] * rays
                on = (np.abs(at[..., 0] - 0.8) <= SIDE + 1e-9) & (np.abs(at[..., 1]) <= SIDE + 1e-9)
                on &= (at[..., 2] >= TABLE) & (at[..., 2] <= TOP + 1e-9) & (side > 0.0)
                z = np.where(on, np.minimum(z, side), z)
    noise = np.random.default_rng(0).normal(0.0, sigma, z.shape) if sigma else 0.0
    return quantised(np.where(z > 0.0, z, np.inf) + noise)


def shown(u: float, v: float, colours: Depth) -> Array:
    """Return the world point that the colours show at a pixel's centre."""
    z = float(colours[int(v), int(u)])
    return apply(WORLD_FROM_CAMERA, CAMERA.point_from_pixel(u, v, z))


@SOME
@given(
    turn=st.tuples(st.floats(-0.08, 0.08), st.floats(-0.08, 0.08)),
    shift=st.tuples(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05), st.floats(-0.05, 0.05)),
    sigma=st.sampled_from([0.0, 0.002]),
    u=st.integers(100, 220),
    v=st.integers(80, 160),
)
def test_what_a_pixel_shows_is_found_however_the_camera_moved(
    turn: tuple[float, float], shift: tuple[float, float, float], sigma: float, u: int, v: int
) -> None:
    depth_from_colours = moved(turn, shift)
    world_from_depth = WORLD_FROM_CAMERA @ inverse(depth_from_colours)
    depth = seen_from(world_from_depth, box=False, sigma=sigma)
    truth = shown(u + 0.5, v + 0.5, seen_from(WORLD_FROM_CAMERA, box=False))

    match = find_in_depth(depth, CAMERA, depth_from_colours, u + 0.5, v + 0.5)
    surface = lift(depth, CAMERA, world_from_depth, match.u, match.v)

    assert match.hidden == 0.0
    error = float(np.linalg.norm(surface.point - truth))
    assert error <= surface.error_bound + 0.0005
    assert error <= 0.001 + 0.5 * sigma


def test_a_camera_that_did_not_move_shows_the_same_pixel() -> None:
    match = find_in_depth(seen_from(WORLD_FROM_CAMERA), CAMERA, np.eye(4), 101.3, 77.8)
    assert (match.u, match.v) == pytest.approx((101.3, 77.8), abs=1e-9)


def test_on_a_box_the_answer_is_what_the_colours_show_or_says_what_depth_did_not_see() -> None:
    """A head that turns and sways by 3 cm between colours and depth: 13 px, at every pixel."""
    depth_from_colours = moved((0.01, 0.03), (0.03, 0.0, 0.01))
    world_from_depth = WORLD_FROM_CAMERA @ inverse(depth_from_colours)
    depth, colours = seen_from(world_from_depth), seen_from(WORLD_FROM_CAMERA)
    errors, bounds, naive, refused = [], [], [], 0
    for v in range(60, 200, 13):
        for u in range(70, 250, 13):
            truth = shown(u + 0.5, v + 0.5, colours)
            try:
                match = find_in_depth(depth, CAMERA, depth_from_colours, u + 0.5, v + 0.5)
                surface = lift(depth, CAMERA, world_from_depth, match.u, match.v)
            except RefusedError:
                refused += 1
                continue
            errors.append(float(np.linalg.norm(surface.point - truth)))
            bounds.append(surface.error_bound + match.hidden)
            naive.append(float(np.linalg.norm(shown(u + 0.5, v + 0.5, depth) - truth)))

    covered = np.asarray(errors) <= np.asarray(bounds) + 1e-3
    assert covered.mean() >= 0.97
    assert np.median(errors) < 0.001
    assert np.percentile(errors, 90) < 0.01
    assert np.median(naive) > 0.005, "the same without the stamp"
    assert refused < 0.05 * len(errors)


def test_the_foreground_wins_where_both_are_on_the_ray() -> None:
    """The box hides the table from the colours; depth, from the side, sees both on that ray."""
    depth_from_colours = moved((0.0, 0.0), (0.05, 0.0, 0.0))
    world_from_depth = WORLD_FROM_CAMERA @ inverse(depth_from_colours)
    u, v = CAMERA.pixel_from_point(apply(inverse(WORLD_FROM_CAMERA), [0.8, 0.1, TOP]))

    match = find_in_depth(seen_from(world_from_depth), CAMERA, depth_from_colours, u, v)
    surface = lift(seen_from(world_from_depth), CAMERA, world_from_depth, match.u, match.v)

    assert surface.point == pytest.approx([0.8, 0.1, TOP], abs=2e-3)


def test_beside_what_depth_saw_it_is_refused() -> None:
    depth = seen_from(WORLD_FROM_CAMERA)
    with pytest.raises(RefusedError, match="another instant"):
        find_in_depth(depth, CAMERA, moved((0.0, 0.6), (0.0, 0.0, 0.01)), 300.0, 100.0)
    with pytest.raises(RefusedError, match="another instant"):
        find_in_depth(depth, CAMERA, moved((3.0, 0.0), (0.0, 0.0, 0.0)), 160.0, 100.0)
    nothing = np.zeros((HEIGHT, WIDTH), np.float32)
    with pytest.raises(RefusedError, match="another instant"):
        find_in_depth(nothing, CAMERA, moved((0.0, 0.0), (0.1, 0.0, 0.0)), 160.0, 100.0)


def test_a_grid_of_codes_follows_what_it_speaks_of() -> None:
    depth_from_colours = moved((0.0, 0.0), (0.08, 0.0, 0.0))
    world_from_depth = WORLD_FROM_CAMERA @ inverse(depth_from_colours)
    depth, colours = seen_from(world_from_depth), seen_from(WORLD_FROM_CAMERA)
    side = 8
    on_box = [_on_box(picture, place)[4::side, 4::side] for picture, place in
              ((depth, world_from_depth), (colours, WORLD_FROM_CAMERA))]  # fmt: skip

    grid = to_colours(on_box[0].astype(np.uint8), depth, CAMERA, depth_from_colours, side, unseen=7)

    assert (on_box[0] != on_box[1]).sum() > 20
    assert ((grid == 1) != on_box[1]).sum() < 0.3 * (on_box[0] != on_box[1]).sum()
    assert (grid[:, :1] == 7).any() or (grid[:, -1:] == 7).any(), "depth did not see that side"


def test_points_take_the_colours_of_where_the_colours_show_them() -> None:
    depth_from_colours = moved((0.0, 0.02), (0.05, 0.0, 0.0))
    world_from_depth = WORLD_FROM_CAMERA @ inverse(depth_from_colours)
    colours = seen_from(WORLD_FROM_CAMERA)
    picture = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    picture[_on_box(colours, WORLD_FROM_CAMERA)] = (250, 0, 0)

    def red_shares(depth_from_colours: Matrix | None) -> tuple[float, float]:
        cloud = point_cloud(
            seen_from(world_from_depth), picture, CAMERA, world_from_depth,
            Box((0.4, -0.5, 0.7), (1.2, 0.5, 1.1)), voxel=0.01, most=100_000,
            depth_from_colours=depth_from_colours,
        )  # fmt: skip
        red, on_top = cloud.colours[:, 0] > 125, cloud.points[:, 2] > TOP - 0.01
        return float(red[on_top].mean()), float(red[~on_top & (cloud.points[:, 2] < 0.81)].mean())

    on_top, on_table = red_shares(depth_from_colours)
    assert on_top > 0.97
    assert on_table < 0.03
    assert red_shares(None)[0] < 0.9


def _on_box(picture: Depth, world_from_camera: Matrix) -> np.ndarray:
    points = apply(world_from_camera, (picture[..., None] * all_rays()).reshape(-1, 3))
    return np.asarray((points[:, 2] > TABLE + 0.005).reshape(picture.shape))
