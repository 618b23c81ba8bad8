"""Stop and resume, as the operator sees them, in a real browser."""

import json
from collections.abc import Callable
from typing import Any

import pytest

from fakes.console_world import ConsoleWorld
from fakes.table_picture import make_target
from support.waiting import wait_until

pytestmark = pytest.mark.browser

SECOND = 1_000_000_000

Open = Callable[..., Any]


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


def test_a_late_state_of_before_the_resume_is_not_shown_as_holding_again(
    world: ConsoleWorld, open_page: Open
) -> None:
    page = open_page()
    status = page.get_by_role("status", name="Stop status")
    page.get_by_role("button", name="Stop").click()
    status.get_by_text("holding (acknowledged at").wait_for()
    world.robot.is_late = True
    page.get_by_role("button", name="Resume").click()
    status.get_by_text("resumed").wait_for()
    page.wait_for_timeout(1000)
    assert "resumed" in status.inner_text()
    world.robot.is_late = False
    world.robot.mode = "stopped"
    status.get_by_text("holding (stopped)").wait_for()


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


def test_a_hold_of_the_controller_is_shown_with_its_reason_and_ends_with_resume(
    world: ConsoleWorld, open_page: Open
) -> None:
    page = open_page()
    status = page.get_by_role("status", name="Stop status")
    world.holding = "the elbow turns at 9.00 rad/s, limit 3.00"
    status.get_by_text("holding (the controller)").wait_for()
    status.get_by_text("9.00 rad/s").wait_for()
    page.get_by_role("button", name="Resume").click()
    wait_until(lambda: world.holding == "")
    status.get_by_text("holding (the controller)").wait_for(state="hidden")
    # The button follows the next status, the text already the answer to the click.
    page.get_by_role("button", name="Resume").wait_for(state="hidden")


def test_a_controller_that_holds_again_at_once_is_never_shown_as_resumed(
    world: ConsoleWorld, open_page: Open
) -> None:
    page = open_page()
    status = page.get_by_role("status", name="Stop status")
    world.finds_it_again, world.holding = True, "the left knee bears 900 Nm"
    status.get_by_text("holding (the controller)").wait_for()
    with page.expect_response("**/api/resume") as answer:
        page.get_by_role("button", name="Resume").click()
    assert answer.value.status == 409
    assert "900 Nm" in answer.value.text()
    status.get_by_text("900 Nm").wait_for()
    assert status.get_by_text("resumed").count() == 0
    assert page.get_by_role("button", name="Resume").is_visible()
