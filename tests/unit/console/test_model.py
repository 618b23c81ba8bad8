"""What the console knows, and what it tells the page of it."""

from fakes.table_picture import BOOK_TOP, make_target
from w2c.messages import CameraFrame, GoalEvent, Target, Turn
from w2c_console.journal import ENTRIES_KEPT
from w2c_console.model import ConsoleModel
from w2c_console.page import GoalEntry, TurnEntry
from w2c_console.view import FRAMES_KEPT

SECOND = 1_000_000_000


def frame(stamp_ns: int) -> CameraFrame:
    return CameraFrame(
        stamp_ns=stamp_ns,
        frame="camera",
        width=64,
        height=48,
        intrinsics=(50.0, 50.0, 32.0, 24.0),
        jpeg=b"jpeg",
        depth=b"",
    )


def turn(text: str) -> Turn:
    return Turn(stamp_ns=7, text=text, module="none", reply="no", ok=False, seconds=0.1)


def after(state: str, target: Target | None = None) -> Turn:
    return Turn(
        stamp_ns=7,
        text="",
        module="none",
        reply="so be it",
        ok=True,
        target=target,
        state=state,  # type: ignore[arg-type]
        seconds=0.1,
    )


def test_before_the_first_picture_the_header_says_so() -> None:
    model = ConsoleModel()
    header = model.header(model.scene(live=False), 5 * SECOND)
    assert (header.sequence, header.stamp) == (0, "-1")


def test_stamps_survive_numbers_that_javascript_cannot_hold() -> None:
    model = ConsoleModel()
    stamp = 1_795_000_000_123_456_789
    model.on_frame(frame(stamp), SECOND)
    assert model.header(model.scene(live=False), SECOND).stamp == str(stamp)


def test_the_age_of_a_frozen_picture_and_the_silence_of_the_camera_are_told_apart() -> None:
    model = ConsoleModel()
    model.on_frame(frame(SECOND), 10 * SECOND)
    model.on_frame(frame(2 * SECOND), 13 * SECOND)
    model.on_target(make_target("t-1", SECOND, point=None))
    header = model.header(model.scene(live=False), 14 * SECOND)
    assert header.frozen
    assert (header.age_s, header.silent_s) == (4.0, 1.0)


def test_the_picture_of_a_target_without_depth_is_kept_until_it_is_decided() -> None:
    model = ConsoleModel()
    model.on_frame(frame(SECOND), 0)
    model.on_target(make_target("t-1", SECOND, point=None))
    for index in range(2, 2 * FRAMES_KEPT):
        model.on_frame(frame(index * SECOND), 0)
    scene = model.scene(live=False)
    assert scene.frozen
    assert scene.frame is not None
    assert scene.frame.stamp_ns == SECOND


def test_what_the_robot_moves_to_stays_in_sight_while_another_target_is_shown() -> None:
    model = ConsoleModel()
    model.on_frame(frame(SECOND), 0)
    confirmed = make_target("t-1", SECOND, state="confirmed")
    model.on_target(confirmed)
    model.on_turn(after("moving", confirmed), 0)
    alone = model.scene(live=False)
    assert (alone.marker is not None, alone.destination, alone.moving_to) == (True, None, "")

    proposed = make_target("t-2", SECOND, point=BOOK_TOP + 0.05)
    model.on_target(proposed)
    model.on_turn(after("moving", proposed), 0)
    both = model.scene(live=False)
    assert both.marker is not None
    assert both.destination is not None
    assert (both.marker.target_id, both.marker.state) == ("t-2", "proposed")
    assert (both.destination.target_id, both.moving_to) == ("t-1", "t-1")
    assert (both.destination.u, both.destination.v) == (confirmed.u, confirmed.v)

    model.on_frame(frame(2 * SECOND), 0)  # the camera's pose is not known there
    unplaced = model.scene(live=True)
    assert (unplaced.destination, unplaced.moving_to) == (None, "t-1")

    model.on_turn(after("in_contact"), 0)
    assert model.scene(live=False).moving_to == ""


def test_a_target_that_is_taken_back_leaves_the_one_of_the_motion() -> None:
    model = ConsoleModel()
    model.on_frame(frame(SECOND), 0)
    confirmed = make_target("t-1", SECOND, state="confirmed")
    model.on_turn(after("moving", confirmed), 0)
    dropped = make_target("t-2", SECOND, state="abandoned")
    model.on_target(dropped)
    model.on_turn(after("moving", dropped), 0)
    scene = model.scene(live=False)
    panel = model.panel(0).target
    assert scene.marker is not None
    assert panel is not None
    assert (scene.marker.target_id, scene.moving_to, panel.target_id) == ("t-1", "", "t-1")
    model.on_turn(after("idle"), 0)
    assert model.scene(live=False).marker is None


def test_listeners_hear_of_pictures_targets_and_chat_until_they_leave() -> None:
    model = ConsoleModel()
    heard: list[str] = []
    forget = model.listen(lambda: heard.append("news"))
    model.on_frame(frame(SECOND), 0)
    model.on_target(make_target("t-1", SECOND))
    model.on_turn(turn("hello"), 0)
    assert len(heard) == 3
    forget()
    model.on_turn(turn("hello"), 0)
    assert len(heard) == 3


def test_a_page_that_was_away_gets_what_it_missed_in_order() -> None:
    model = ConsoleModel()
    model.on_turn(turn("one"), 1)
    event = GoalEvent(
        stamp_ns=1,
        goal_id="g-1",
        end_effector="right_hand",
        task="contact",
        state="unreachable",
        reason="8 cm too far",
    )
    model.on_goal(event, 2)
    model.on_turn(turn("two"), 3)
    missed = model.entries(after=1)
    assert [entry.id for entry in missed] == [2, 3]
    goal, second = missed
    assert isinstance(goal, GoalEntry)
    assert (goal.end_effector, goal.reason) == ("right hand", "8 cm too far")
    assert isinstance(second, TurnEntry)
    assert second.text == "two"


def test_the_chat_does_not_grow_for_ever() -> None:
    model = ConsoleModel()
    for index in range(ENTRIES_KEPT + 20):
        model.on_turn(turn(str(index)), 0)
    entries = model.entries(after=0)
    assert len(entries) == ENTRIES_KEPT
    assert entries[-1].id == ENTRIES_KEPT + 20
