"""The picture and what is drawn on it, in a real browser."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from fakes.console_world import ConsoleWorld
from fakes.table_picture import BOOK_TOP, WIDTH, camera_pose, make_target, pixel_of
from support.console_page import box_of, dot_on_picture, picture_shown, say
from support.waiting import wait_until
from w2c_console.view import POSE_PATIENCE_NS

pytestmark = pytest.mark.browser

SECOND = 1_000_000_000
EPOCH = 1_795_000_000_123_456_789
"""A stamp that a JavaScript number cannot hold"""

Open = Callable[..., Any]


@pytest.mark.parametrize("width", [1280, 700])
def test_the_dot_is_on_the_named_pixel(world: ConsoleWorld, open_page: Open, width: int) -> None:
    world.take_picture(SECOND)
    target = make_target("t-1", SECOND)
    world.dialogue.show(target)
    page = open_page(width)
    page.get_by_role("img", name="target t-1").wait_for()
    assert dot_on_picture(page) == pytest.approx((target.u, target.v), abs=1.0)
    page.get_by_role("img", name="object book").wait_for()


def test_the_picture_is_drawn_where_the_overlay_says(world: ConsoleWorld, open_page: Open) -> None:
    """The colour under the dot is the book's: picture and overlay have one scale and origin."""
    world.take_picture(SECOND)
    world.dialogue.show(make_target("t-1", SECOND))
    page = open_page(700)
    page.get_by_role("img", name="target t-1").wait_for()
    u, v = dot_on_picture(page)
    pixel = page.evaluate(
        "([u, v]) => [...document.querySelector('#canvas').getContext('2d')"
        ".getImageData(u, v, 1, 1).data]",
        [u, v],
    )
    red, green, blue, _ = pixel
    assert green > red + 20
    assert green > blue


def test_the_dot_follows_the_point_when_the_head_turns(
    world: ConsoleWorld, open_page: Open
) -> None:
    world.take_picture(SECOND)
    world.dialogue.show(make_target("t-1", SECOND))
    page = open_page()
    page.get_by_role("img", name="target t-1").wait_for()
    before = dot_on_picture(page)
    world.take_picture(2 * SECOND, yaw=0.1)
    expected = pixel_of(BOOK_TOP, camera_pose(0.1))
    wait_until(lambda: abs(dot_on_picture(page)[0] - before[0]) > 20)
    assert dot_on_picture(page) == pytest.approx(expected, abs=1.0)


def test_a_prediction_is_blue_and_a_correction_yellow(world: ConsoleWorld, open_page: Open) -> None:
    world.take_picture(SECOND)
    page = open_page()
    for corrections, name, expected in (
        (0, "t-1", "rgb(74, 168, 255)"),
        (1, "t-2", "rgb(255, 212, 59)"),
    ):
        world.dialogue.show(make_target(name, SECOND, corrections=corrections))
        dot = page.get_by_role("img", name=f"target {name}").locator(".dot")
        assert dot.evaluate("dot => getComputedStyle(dot).fill") == expected


@pytest.mark.parametrize("width", [1280, 700])
def test_a_click_points_at_the_pixel_under_it(
    world: ConsoleWorld, open_page: Open, width: int
) -> None:
    world.take_picture(EPOCH)
    page = open_page(width)
    picture_shown(page)
    canvas = page.locator("#canvas").bounding_box()
    scale = canvas["width"] / WIDTH
    page.mouse.click(canvas["x"] + 320 * scale, canvas["y"] + 500 * scale)
    wait_until(lambda: len(world.dialogue.pointed) == 1)
    (point,) = world.dialogue.pointed
    # The mouse knows whole pixels of the screen only.
    assert (point.u, point.v) == pytest.approx((320, 500), abs=1.0 / scale)
    assert point.frame_stamp_ns == EPOCH


def test_neither_stop_nor_confirm_moves_when_there_is_something_to_say(
    world: ConsoleWorld, open_page: Open
) -> None:
    """A button that moves is pressed by mistake."""
    world.take_picture(SECOND)
    world.dialogue.show(make_target("t-1", SECOND, point=None))
    page = open_page(700, 1000)
    buttons = [page.get_by_role("button", name=name) for name in ("Stop", "Confirm t-1")]
    before = [button.bounding_box() for button in buttons]
    world.take_picture(2 * SECOND)
    page.get_by_text("Picture frozen").wait_for()
    assert [button.bounding_box() for button in buttons] == before
    buttons[0].click()
    page.get_by_text("holding (acknowledged at").wait_for()
    page.get_by_role("button", name="Resume").wait_for()
    assert buttons[0].bounding_box() == before[0]


def test_the_page_says_when_there_is_no_picture(world: ConsoleWorld, open_page: Open) -> None:
    world.take_picture(SECOND)
    page = open_page()
    picture_shown(page)
    alarm = page.get_by_role("alert")
    assert alarm.is_hidden()
    alarm.get_by_text("no picture for").wait_for()
    world.take_picture(2 * SECOND)
    alarm.wait_for(state="hidden")


def test_the_page_freezes_on_a_target_without_depth_and_says_so(
    world: ConsoleWorld, open_page: Open
) -> None:
    world.take_picture(SECOND)
    target = make_target("t-1", SECOND, point=None)
    world.dialogue.show(target)
    page = open_page()
    page.get_by_role("img", name="target t-1").wait_for()
    world.take_picture(2 * SECOND, yaw=0.2)
    page.get_by_role("status", name="Notice").get_by_text("Picture frozen").wait_for()
    assert dot_on_picture(page) == pytest.approx((target.u, target.v), abs=1.0)
    say(page, "a bit to the left")
    wait_until(lambda: len(world.dialogue.said) == 1)
    assert world.dialogue.said[0].frame_stamp_ns == SECOND  # of the picture that is seen
    page.get_by_role("button", name="Show live picture").click()
    page.get_by_role("img", name="target").wait_for(state="hidden")
    assert page.get_by_role("button", name="Confirm").is_disabled()
    page.get_by_role("button", name="Back to the target").click()
    page.get_by_role("img", name="target t-1").wait_for()


def test_a_silent_perception_freezes_the_page_too(world: ConsoleWorld, open_page: Open) -> None:
    world.take_picture(SECOND, view=False)
    world.dialogue.show(make_target("t-1", SECOND))
    page = open_page()
    page.get_by_role("img", name="target t-1").wait_for()
    world.take_picture(2 * SECOND + POSE_PATIENCE_NS, yaw=0.2, view=False)
    page.get_by_text("perception is silent").wait_for()


def test_what_the_robot_moves_to_and_what_waits_for_a_yes_are_told_apart(
    world: ConsoleWorld, open_page: Open
) -> None:
    world.take_picture(SECOND)
    page = open_page(420)
    confirmed = make_target("t-1", SECOND, state="confirmed")
    world.dialogue.show(confirmed)
    world.dialogue.turn("yes", "confirmation", "On my way.", target=confirmed, state="moving")
    page.get_by_role("img", name="target t-1").wait_for()
    words = page.get_by_role("region", name="Target").get_by_text("on top of the book")
    words.wait_for()
    before = box_of(page.locator("#confirm"))["y"]
    proposed = make_target("t-2", SECOND, point=BOOK_TOP + np.array([0.0, 0.2, 0.0]))
    world.dialogue.show(proposed)
    destination = page.get_by_role("img", name="moving to t-1")
    destination.wait_for()
    page.get_by_role("img", name="target t-2").wait_for()
    page.get_by_role("button", name="Confirm t-2").wait_for()
    page.get_by_role("region", name="Target").get_by_text("moving to t-1").wait_for()
    words.wait_for()
    assert box_of(page.locator("#confirm"))["y"] == before
    assert destination.locator("circle").count() == 0  # another shape, not only another colour
    world.dialogue.turn("", "none", "There.", state="in_contact")
    destination.wait_for(state="hidden")


def test_the_allowed_area_is_shaded_on_its_own_picture_and_can_be_hidden(
    world: ConsoleWorld, open_page: Open
) -> None:
    cells = np.ones((9, 16), np.uint8)
    cells[:, 8:] = 0  # the right half
    world.take_picture(SECOND)
    page = open_page()
    picture_shown(page)
    shade = page.get_by_role("img", name="Allowed area")
    switch = page.get_by_role("checkbox", name="A hand may go here")
    assert switch.count() == 0
    world.dialogue.allow(7, cells)  # of another picture
    world.dialogue.show(make_target("t-1", SECOND))
    page.get_by_role("img", name="target t-1").wait_for()
    wait_until(lambda: page.locator("#area").evaluate("shade => shade.width") == 16)
    assert shade.is_hidden()
    world.dialogue.allow(SECOND, cells)
    shade.wait_for()
    assert box_of(shade) == box_of(page.locator("#canvas"))
    opacity = "shade => [7, 8].map(u => shade.getContext('2d').getImageData(u, 4, 1, 1).data[3])"
    left, right = shade.evaluate(opacity)
    assert left == 0
    assert 40 < right < 160  # the picture shows through

    switch.uncheck()
    shade.wait_for(state="hidden")
    switch.check()
    shade.wait_for()
    world.take_picture(2 * SECOND, yaw=0.1)  # the head turns: it would lie on other things now
    shade.wait_for(state="hidden")
    switch.wait_for(state="hidden")
