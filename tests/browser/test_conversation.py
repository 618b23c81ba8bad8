"""Words, confirmation, connection and panels, in a real browser."""

from collections.abc import Callable
from typing import Any

import pytest

from fakes.console_world import ConsoleWorld
from fakes.table_picture import make_target
from support.console_page import box_of, picture_shown, say
from support.waiting import wait_until

pytestmark = pytest.mark.browser

SECOND = 1_000_000_000
EPOCH = 1_795_000_000_123_456_789
"""A stamp that a JavaScript number cannot hold"""

Open = Callable[..., Any]


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


def test_an_announcement_of_the_robot_needs_no_words_of_the_operator(
    world: ConsoleWorld, open_page: Open
) -> None:
    page = open_page()
    world.dialogue.turn("", "none", "I gave up on the target.", ok=False)
    page.get_by_role("log").get_by_text("I gave up on the target.").wait_for()
    assert page.get_by_role("log").locator(".said").count() == 0
    world.dialogue.turn("", "confirmation", "I lean on it.")
    page.get_by_role("log").get_by_text("(confirms)").wait_for()


def test_a_question_is_answered_by_its_buttons_until_the_conversation_goes_on(
    world: ConsoleWorld, open_page: Open
) -> None:
    world.take_picture(EPOCH)
    world.dialogue.show(make_target("t-1", EPOCH))
    page = open_page()
    page.get_by_role("img", name="target t-1").wait_for()
    answers = page.get_by_role("group", name="Answers").get_by_role("button")
    world.dialogue.ask("to the mug", "Which 'mug': left or right?", ["left", "right"])
    answers.nth(1).wait_for()
    world.dialogue.turn("", "none", "My right hand has reached the target.")  # by itself
    world.dialogue.turn("er", "none", "What? Still open: Which 'mug': left or right?", ok=False)
    page.get_by_role("listitem").filter(has_text="Still open").get_by_role("group").wait_for()
    assert answers.all_inner_texts() == ["left", "right"]

    long = "the mug with <b>the blue handle</b> " + "m" * 120
    world.dialogue.ask("to the mug", "Which of these?", [long, "right"])
    answers.first.get_by_text("<b>the blue handle</b>").wait_for()  # as text, never as markup
    chat = box_of(page.get_by_role("region", name="Conversation"))
    assert all(box_of(one)["width"] < chat["width"] for one in answers.all())
    assert answers.count() == 2

    page.get_by_label("Instruction").focus()
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Enter")
    page.get_by_text("Is this where you mean? (right)").wait_for()
    assert answers.count() == 0
    (said,) = world.dialogue.said
    assert (said.text, said.frame_stamp_ns, said.target_id) == ("right", EPOCH, "t-1")
    page.keyboard.type("there")
    assert page.get_by_label("Instruction").input_value() == "there"


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


def test_advice_stands_beside_the_target_and_a_veto_takes_confirm_away(
    world: ConsoleWorld, open_page: Open
) -> None:
    world.take_picture(SECOND)
    world.dialogue.show(make_target("t-1", SECOND))
    page = open_page()
    confirm = page.get_by_role("button", name="Confirm t-1")
    confirm.wait_for()
    region = page.get_by_role("region", name="Advice")
    before = [box_of(page.get_by_role("button", name=name)) for name in ("Confirm", "Send")]
    world.dialogue.advise("t-0", refusal="of a target that is not seen")
    world.dialogue.advise("t-1", caution="looks like <b>glass</b>", unchecked="flame")
    region.get_by_text("looks like <b>glass</b>").wait_for()  # as text, never as markup
    region.get_by_text("1 check was not made in full").click()
    region.get_by_text("veto: flame").wait_for()
    assert confirm.is_enabled()

    world.dialogue.advise("t-1", caution="looks like glass", refusal="I see 'person' there")
    region.get_by_role("listitem", name="veto").get_by_text("I see 'person' there").wait_for()
    assert confirm.is_disabled()
    assert confirm.get_attribute("title") == "I see 'person' there"
    texts = region.get_by_role("listitem").all_inner_texts()
    assert [text.lower() for text in texts] == ["i see 'person' there", "looks like glass"]
    after = [box_of(page.get_by_role("button", name=name)) for name in ("Confirm", "Send")]
    assert before == after

    world.dialogue.show(make_target("t-2", SECOND))
    page.get_by_role("button", name="Confirm t-2").wait_for()
    assert page.get_by_role("button", name="Confirm t-2").is_enabled()
    assert region.get_by_role("listitem").count() == 0
