"""Where a hand may go in a picture: on a table; not at an edge, a step, a slope, an arm."""

import time
from typing import Any

import numpy as np
import pytest

from support.surfaces import (
    CAMERA,
    HEIGHT,
    TABLE,
    WIDTH,
    WORLD_FROM_CAMERA,
    all_rays,
    book,
    depth_of,
    noisy,
    quantised,
)
from w2c.geometry import Intrinsics
from w2c_perception.allowed import (
    ALLOWED,
    ARM,
    CELL,
    SMALL,
    STEEP,
    UNEVEN,
    UNSEEN,
    allowed_cells,
)
from w2c_perception.fitness import Demands

NO_ARMS = np.zeros((0, 2, 3))


def cells(depth: np.ndarray, **options: Any) -> np.ndarray:
    arms = options.pop("arms", NO_ARMS)
    return allowed_cells(
        depth.astype(np.float32),
        CAMERA,
        WORLD_FROM_CAMERA,
        arms,
        **options,
    )


def at(codes: np.ndarray, u: float, v: float) -> int:
    return int(codes[int(v) // CELL, int(u) // CELL])


def test_the_cells_cover_the_picture() -> None:
    assert cells(quantised(TABLE)).shape == (HEIGHT // CELL, WIDTH // CELL)


@pytest.mark.parametrize("sigma", [0.0, 0.003])
def test_a_table_is_allowed_with_noise_and_holes_too(sigma: float) -> None:
    depth = noisy(TABLE, sigma)
    depth[np.random.default_rng(0).random(depth.shape) < 0.05] = 0.0

    inner = cells(depth)[4:-4, 4:-4]

    assert np.mean(inner == ALLOWED) > 0.97


def test_beside_a_step_is_not_allowed_farther_away_it_is() -> None:
    depth, inside = book(height=0.1)
    rows, columns = np.nonzero(inside)
    u, v = float(columns.mean()), float(rows.mean())

    codes = cells(depth)

    assert at(codes, u, v) == ALLOWED
    assert at(codes, columns.max(), v) in {UNEVEN, SMALL}
    assert at(codes, columns.max() + 8, v) in {UNEVEN, SMALL}
    assert at(codes, columns.max() + 45, v) == ALLOWED


def test_something_small_is_too_small() -> None:
    depth = TABLE.copy()
    depth[100:112, 150:165] -= 0.15  # 5 cm wide, and high

    codes = cells(quantised(depth))

    assert at(codes, 157, 106) in {UNEVEN, SMALL}


@pytest.mark.parametrize(("degrees", "expected"), [(20.0, ALLOWED), (40.0, STEEP)])
def test_slopes_beyond_friction_are_not_allowed(degrees: float, expected: int) -> None:
    angle = np.radians(degrees)
    depth = depth_of(np.array([-np.sin(angle), 0.0, np.cos(angle)]), np.array([0.8, 0.0, 0.8]))

    assert at(cells(quantised(depth)), 160, 120) == expected


def test_a_wall_is_allowed_where_pushes_count() -> None:
    wall = quantised(depth_of(np.array([-1.0, 0.0, 0.0]), np.array([0.9, 0.0, 0.0])))

    assert at(cells(wall), 160, 120) == ALLOWED
    assert at(cells(wall, walls=False), 160, 120) == STEEP


def test_what_was_not_seen_is_not_allowed() -> None:
    depth = quantised(TABLE)
    depth[:, 200:] = 0.0

    codes = cells(depth)

    assert at(codes, 260, 120) == UNSEEN
    assert at(codes, 196, 120) != ALLOWED
    assert (cells(np.zeros((HEIGHT, WIDTH))) == UNSEEN).all()


def test_the_robots_own_arm_is_not_allowed() -> None:
    points = all_rays()[120, 160] * TABLE[120, 160]
    middle = WORLD_FROM_CAMERA[:3, :3] @ points + WORLD_FROM_CAMERA[:3, 3]
    arm = np.array([[middle - np.array([0.0, 0.3, 0.0]), middle + np.array([0.0, 0.0, 0.05])]])

    codes = cells(quantised(TABLE), arms=arm)

    assert at(codes, 160, 120) == ARM
    assert at(codes, 60, 200) == ALLOWED


def test_a_smaller_hand_is_allowed_nearer_to_an_edge() -> None:
    depth, _ = book(height=0.1)

    large = np.mean(cells(depth, demands=Demands(radius=0.05)) == ALLOWED)
    small = np.mean(cells(depth, demands=Demands(radius=0.015)) == ALLOWED)

    assert small > large + 0.02


def test_a_full_picture_takes_less_than_150_milliseconds() -> None:
    """Against a reference that any machine of today does in about the same time."""
    intrinsics = Intrinsics(938.0, 938.0, 640.0, 360.0)
    depth = np.full((720, 1280), 0.9, np.float32)
    depth += np.random.default_rng(0).normal(0.0, 0.002, depth.shape).astype(np.float32)
    block = np.random.default_rng(1).random(1_000_000)
    allowed_cells(depth, intrinsics, WORLD_FROM_CAMERA, NO_ARMS)

    def cpu(work: object) -> float:
        started = time.thread_time()
        work()  # type: ignore[operator]
        return time.thread_time() - started

    reference = min(cpu(lambda: np.sort(block)) for _ in range(3))
    found = min(
        cpu(lambda: allowed_cells(depth, intrinsics, WORLD_FROM_CAMERA, NO_ARMS)) for _ in range(3)
    )

    assert found < 5.0 * reference + 0.05
