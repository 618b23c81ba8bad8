"""A centimetre of words is as long as it looks in the picture, where that is known."""

import numpy as np
import pytest

from support.conversing import CUP, FIRST, World, first_words
from w2c.errors import RefusedError, UnavailableError, W2CError
from w2c.messages import CameraView
from w2c_dialogue.beside import INSIDE
from w2c_dialogue.frames import DEFAULT_PIXELS_PER_CM

TEXT = "Lean 12 cm left of the cup"
FOCAL_PX = 1200.0
TABLE_M = 0.8
"""In front of the camera: the depth that the fake tells"""


def world() -> World:
    return World(
        analyze=[{"position": "relative", "objects": ["7-7"]}],
        relative=[{"x": "a.left-12*cm", "y": "a.v"}],
    )


def add_view(world: World) -> None:
    world.frames.add_view(
        CameraView(
            stamp_ns=100,
            world_from_camera=np.eye(4),
            intrinsics=(FOCAL_PX, FOCAL_PX, 640.0, 360.0),
            width=1280,
            height=720,
        )
    )


def centimetre_of(world: World) -> float:
    target = world.say(TEXT).target
    assert target is not None
    stands = CUP[0] + INSIDE * min(CUP[2] - CUP[0], CUP[3] - CUP[1])
    return (stands - target.u) / 12.0


def test_a_centimetre_is_as_long_as_the_depth_of_the_thing_says() -> None:
    told = world()
    add_view(told)
    assert centimetre_of(told) == pytest.approx(0.01 * FOCAL_PX / TABLE_M)
    u, v, stamp_ns = told.lift.asked[0]
    assert CUP[0] < u < CUP[2]
    assert CUP[1] < v < CUP[3]
    assert stamp_ns == 100


@pytest.mark.parametrize("error", [RefusedError("no depth there"), UnavailableError("nobody")])
def test_without_depth_a_centimetre_is_ten_pixels(error: W2CError) -> None:
    told = world()
    add_view(told)
    told.lift.error = error
    assert centimetre_of(told) == pytest.approx(DEFAULT_PIXELS_PER_CM)


def test_without_the_cameras_pose_nobody_is_asked_for_depth_there() -> None:
    told = world()
    assert centimetre_of(told) == pytest.approx(DEFAULT_PIXELS_PER_CM)
    assert len(told.lift.asked) == 1  # of the target itself


def test_a_correction_from_a_place_without_depth_keeps_the_length_of_a_centimetre() -> None:
    told = World(
        select=["prediction", "correction"],
        correct=[{"x": "target.u+2*cm", "y": "target.v"}],
        **first_words(),
    )
    add_view(told)
    moved = []
    before = told.say(FIRST).target
    told.lift.error = RefusedError("no depth there")
    for _ in range(2):
        assert before is not None
        after = told.say("2 cm to the right").target
        assert after is not None
        assert after.point is None
        moved.append(after.u - before.u)
        before = after
    assert moved == [pytest.approx(2 * 0.01 * FOCAL_PX / TABLE_M)] * 2
