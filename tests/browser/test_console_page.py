"""What the page promises to the operator, one test a promise, in a real browser."""

import json
from collections.abc import Callable
from typing import Any

import pytest

from fakes.console_world import (
    BOOK_TOP,
    HEIGHT,
    WIDTH,
    ConsoleWorld,
    camera_pose,
    make_target,
    pixel_of,
)
from support.waiting import wait_until
from w2c_console.view import POSE_PATIENCE_NS

pytestmark = pytest.mark.browser

SECOND = 1_000_000_000
EPOCH = 1_795_000_000_123_456_789
"""A stamp that a JavaScript number cannot hold"""

Open = Callable[..., Any]


def dot_on_picture(page: Any) -> tuple[float, float]:
    """Return where the middle of the dot is, in pixels of the picture as drawn on the screen."""
    canvas = page.locator("canvas").bounding_box()
    dot = page.get_by_role("img", name="target").locator(".dot").bounding_box()
    u = (dot["x"] + dot["width"] / 2 - canvas["x"]) / canvas["width"] * WIDTH
    v = (dot["y"] + dot["height"] / 2 - canvas["y"]) / canvas["height"] * HEIGHT
    return u, v


def picture_shown(page: Any) -> None:
    """Wait until there is a picture."""
    page.get_by_label("Age of the picture").get_by_text("old").wait_for()


def say(page: Any, text: str) -> None:
    page.get_by_label("Instruction").fill(text)
    page.get_by_role("button", name="Send").click()


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
        "([u, v]) => [...document.querySelector('canvas').getContext('2d')"
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


def test_confirm_sends_the_target_on_the_screen_and_a_stale_one_is_refused_visibly(
    world: ConsoleWorld, open_page: Open
) -> None:
    """The newer target is known to the dialogue, and has not reached the page yet."""
    world.take_picture(SECOND)
    world.dialogue.show(make_target("t-1", SECOND))
    page = open_page()
    button = page.get_by_role("button", name="Confirm t-1")
    button.wait_for()
    world.dialogue.current = "t-2"
    button.click()
    page.get_by_text("t-1 is no longer the target; t-2 is").wait_for()
    assert [confirm.target_id for confirm in world.dialogue.confirmed] == ["t-1"]


def test_confirm_sends_what_is_seen_even_if_the_page_knows_of_a_newer_target(
    world: ConsoleWorld, open_page: Open
) -> None:
    """The picture is late: the news of another target came first."""
    held = False

    def relay(client: Any) -> None:
        server = client.connect_to_server()
        server.on_message(lambda message: None if held else client.send(message))

    world.take_picture(SECOND)
    world.dialogue.show(make_target("t-1", SECOND))
    page = open_page(prepare=lambda page: page.route_web_socket("**/ws/camera", relay))
    words = page.get_by_role("region", name="Target").get_by_text("on top of the book")
    words.wait_for()
    held = True
    world.dialogue.show(make_target("t-2", SECOND))
    words.wait_for(state="hidden")  # they belong to another target than the one that is seen
    page.get_by_role("button", name="Confirm t-1").click()
    wait_until(lambda: len(world.dialogue.confirmed) == 1)
    assert world.dialogue.confirmed[0].target_id == "t-1"


def test_there_is_nothing_to_confirm_without_a_target_on_the_screen(
    world: ConsoleWorld, open_page: Open
) -> None:
    world.take_picture(SECOND)
    page = open_page()
    picture_shown(page)
    assert page.get_by_role("button", name="Confirm").is_disabled()
    world.dialogue.show(make_target("t-1", SECOND))
    page.get_by_role("button", name="Confirm t-1").wait_for()
    assert page.get_by_role("button", name="Confirm t-1").is_enabled()
    world.take_picture(2 * SECOND, view=False)
    world.publish_view(2 * SECOND, yaw=1.5)  # the head looks elsewhere
    page.get_by_text("outside the picture").wait_for()
    assert page.get_by_role("button", name="Confirm").is_disabled()


def test_an_utterance_carries_the_frame_and_the_target_on_the_screen(
    world: ConsoleWorld, open_page: Open
) -> None:
    world.take_picture(EPOCH)
    world.dialogue.show(make_target("t-1", EPOCH))
    page = open_page()
    page.get_by_role("img", name="target t-1").wait_for()
    say(page, "a bit to the left")
    page.get_by_text("Is this where you mean?").wait_for()
    (said,) = world.dialogue.said
    assert (said.text, said.frame_stamp_ns, said.target_id) == ("a bit to the left", EPOCH, "t-1")
    assert page.get_by_role("log").get_by_text("a bit to the left", exact=True).count() == 1


def test_a_refused_utterance_shows_the_reason(world: ConsoleWorld, open_page: Open) -> None:
    world.dialogue.refusal = "I see no unicorn <b>here</b>"
    page = open_page()
    say(page, "to the unicorn")
    page.get_by_text("I see no unicorn <b>here</b>").wait_for()  # as text, never as markup


@pytest.mark.parametrize("width", [1280, 700])
def test_a_click_points_at_the_pixel_under_it(
    world: ConsoleWorld, open_page: Open, width: int
) -> None:
    world.take_picture(EPOCH)
    page = open_page(width)
    picture_shown(page)
    canvas = page.locator("canvas").bounding_box()
    scale = canvas["width"] / WIDTH
    page.mouse.click(canvas["x"] + 320 * scale, canvas["y"] + 500 * scale)
    wait_until(lambda: len(world.dialogue.pointed) == 1)
    (point,) = world.dialogue.pointed
    # The mouse knows whole pixels of the screen only.
    assert (point.u, point.v) == pytest.approx((320, 500), abs=1.0 / scale)
    assert point.frame_stamp_ns == EPOCH


def test_stop_shows_the_acknowledgement_and_resume_ends_it(
    world: ConsoleWorld, open_page: Open
) -> None:
    page = open_page()
    status = page.get_by_role("status", name="Stop status")
    for times in (1, 2):  # idempotent
        page.get_by_role("button", name="Stop").click()
        wait_until(lambda times=times: world.robot.stops == times)  # type: ignore[misc]
        status.get_by_text("holding (acknowledged at").wait_for()
    page.get_by_role("button", name="Resume").click()
    status.get_by_text("resumed").wait_for()
    assert world.robot.mode == "tracking"
    assert page.get_by_role("button", name="Resume").is_hidden()


def test_a_stop_that_nobody_acknowledged_is_never_shown_as_done(
    world: ConsoleWorld, open_page: Open
) -> None:
    page = open_page()
    world.robot.bus.close()
    page.get_by_role("button", name="Stop").click()
    page.get_by_role("status", name="Stop status").get_by_text("STOP NOT DELIVERED").wait_for()
    assert page.get_by_text("acknowledged at").count() == 0


def test_stop_says_so_when_the_console_itself_is_gone(console: Any, open_page: Open) -> None:
    page = open_page()
    console.end()
    page.get_by_role("button", name="Stop").click()
    page.get_by_text("STOP NOT DELIVERED").wait_for()


def test_stop_works_without_the_streams_and_with_only_the_robot_alive(
    world: ConsoleWorld, browser: Any, console: Any
) -> None:
    for bus in (
        world.camera,
        world.perception,
        world.controller,
        world.recorder,
        world.dialogue.bus,
    ):
        bus.close()
    page = browser.new_page()
    page.add_init_script(
        "window.WebSocket = class {"
        "  constructor() { setTimeout(() => this.onclose?.()) } close() {} }"
    )
    page.goto(console.url)
    page.get_by_role("button", name="Stop").click()
    page.get_by_text("holding (acknowledged at").wait_for()
    assert world.robot.mode == "stopped"
    page.close()


def test_stop_works_without_any_script(world: ConsoleWorld, browser: Any, console: Any) -> None:
    page = browser.new_page()
    page.route("**/*.js", lambda route: route.abort())
    page.goto(console.url)
    page.get_by_role("button", name="Stop").click()
    page.wait_for_url("**/api/stop")
    assert json.loads(page.locator("body").inner_text())["acknowledged"] is True
    assert world.robot.mode == "stopped"
    page.close()


def test_space_stops_even_when_confirm_has_the_focus(world: ConsoleWorld, open_page: Open) -> None:
    world.take_picture(SECOND)
    world.dialogue.show(make_target("t-1", SECOND))
    page = open_page()
    page.get_by_role("button", name="Confirm t-1").focus()
    page.keyboard.press("Space")
    page.get_by_text("holding (acknowledged at").wait_for()
    assert world.dialogue.confirmed == []


def test_escape_stops_while_typing_and_space_does_not(world: ConsoleWorld, open_page: Open) -> None:
    page = open_page()
    field = page.get_by_label("Instruction")
    field.focus()
    page.keyboard.type("to the left")
    assert field.input_value() == "to the left"
    assert world.robot.stops == 0
    page.keyboard.press("Escape")
    page.get_by_text("holding (acknowledged at").wait_for()


def test_a_stop_from_elsewhere_can_be_resumed_here(world: ConsoleWorld, open_page: Open) -> None:
    page = open_page()
    world.robot.mode = "stopped"
    page.get_by_role("status", name="Stop status").get_by_text("holding (stopped)").wait_for()
    page.get_by_role("button", name="Resume").click()
    wait_until(lambda: world.robot.mode == "tracking")


def test_a_resume_from_elsewhere_is_shown_here(world: ConsoleWorld, open_page: Open) -> None:
    page = open_page()
    page.get_by_role("button", name="Stop").click()
    page.get_by_text("holding (acknowledged at").wait_for()
    world.robot.stamp_ns += SECOND
    world.robot.mode = "tracking"
    page.get_by_text("holding (acknowledged at").wait_for(state="hidden")
    assert page.get_by_role("button", name="Resume").is_hidden()


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


def test_the_page_reconnects_by_itself_and_keeps_the_conversation(
    world: ConsoleWorld, console: Any, open_page: Open
) -> None:
    page = open_page()
    say(page, "hello")
    page.get_by_text("(hello)").wait_for()
    console.end()
    connection = page.get_by_role("status", name="Connection")
    connection.get_by_text("connection lost").wait_for()
    console.start()
    connection.get_by_text("connected", exact=True).wait_for()
    world.take_picture(SECOND)
    picture_shown(page)
    world.dialogue.turn("from elsewhere", "none", "noted")
    page.get_by_text("noted").wait_for()


def test_a_page_opened_later_sees_the_conversation_and_the_progress(
    world: ConsoleWorld, open_page: Open
) -> None:
    first = open_page()
    say(first, "hello")
    first.get_by_text("(hello)").wait_for()
    world.publish_goal("unreachable", "8 cm too far away")
    second = open_page()
    second.get_by_text("(hello)").wait_for()
    second.get_by_text("8 cm too far away").wait_for()


def test_each_process_and_each_contact_is_shown(world: ConsoleWorld, open_page: Open) -> None:
    page = open_page()
    processes = page.get_by_role("region", name="Processes")
    processes.get_by_role("row", name="controller").get_by_text("ready").wait_for()
    robot = page.get_by_role("region", name="Robot")
    robot.get_by_role("group", name="left foot").get_by_text("431 N").wait_for()
    robot.get_by_text("tracking").wait_for()
    page.get_by_role("status", name="Recorder").get_by_text("18,204 messages").wait_for()
    world.camera.close()
    processes.get_by_role("row", name="camera").get_by_text("gone").wait_for()
