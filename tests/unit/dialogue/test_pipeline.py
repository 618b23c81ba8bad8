"""The conversation of scenario (a), and all that goes wrong in conversations."""

import numpy as np
import pytest

from support.conversing import FIRST, STAY, World, first_words
from w2c.errors import DeadlineError, ModelError, RefusedError, UnavailableError
from w2c.messages import (
    ConfirmRequest,
    PointRequest,
    PreviewReply,
    SayRequest,
)
from w2c_dialogue.frames import FrameStore
from w2c_dialogue.stop_words import is_stop


def test_scenario_a_of_the_paper() -> None:
    reach = "with your left hand, reach for the cup"
    world = World(
        select=["prediction", "correction", "confirmation", "prediction", "confirmation"],
        analyze=[
            {"position": "absolute", "objects": ["9-9"]},
            {"position": "absolute", "objects": ["8-8"]},
        ],
        correct=[{"x": "target.u-20", "y": "target.v"}],
        effector=[
            {"effector": "right_hand", "task": "contact"},
            {"effector": "left_hand", "task": "reach"},
        ],
    )
    turn = world.say(FIRST)
    assert turn.ok
    assert turn.module == "prediction.absolute"
    assert turn.target is not None
    assert (turn.target.u, turn.target.v, turn.target.phrases) == (500, 360, ["book"])
    assert turn.target.frame_stamp_ns == 100
    assert not world.controller.goals

    turn = world.say("move a bit to the left")
    assert turn.module == "correction"
    assert turn.target is not None
    assert (turn.target.u, turn.target.v, turn.target.corrections) == (480, 360, 1)
    assert "20 px left" in turn.reply
    assert not world.controller.goals

    turn = world.say("that's perfect")
    assert turn.module == "confirmation"
    assert turn.target is not None
    assert turn.target.state == "confirmed"
    goal = world.controller.goals[0]
    assert (goal.end_effector, goal.task) == ("right_hand", "contact")
    np.testing.assert_allclose(goal.point, [0.6, 0.16, 0.8])
    assert turn.goal_id == goal.goal_id

    assert world.event(goal.goal_id, "touched") is None
    done = world.event(goal.goal_id, "loaded")
    assert done is not None
    assert done.target is not None
    assert done.target.state == "in_contact"

    assert world.say(reach).ok
    turn = world.say("yes")
    goal = world.controller.goals[1]
    assert (goal.end_effector, goal.task) == ("left_hand", "reach")
    assert world.model.last_question("effector") == reach
    done = world.event(goal.goal_id, "reached", "reach")
    assert done is not None
    assert done.target is not None
    assert done.target.state == "reached"


def test_without_a_target_everything_is_a_prediction_whatever_the_model_says() -> None:
    world = World(select=["confirmation"], **first_words())
    turn = world.say(FIRST)
    assert turn.module == "prediction.absolute"
    assert world.model.priors[0]["confirmation"] < -10
    assert world.model.priors[0]["correction"] < -10


def test_a_yes_needs_the_target_on_the_screen() -> None:
    world = World(
        select=["prediction", "correction", "confirmation"],
        correct=[{"x": "700", "y": "300"}],
        **first_words(),
    )
    world.say(FIRST)
    old = world.shown
    world.say("to 700, 300")
    for stale in (old, "", "target-x-1"):
        turn = world.say("yes", target_id=stale)
        assert not turn.ok
        assert not world.dialogue.confirm(ConfirmRequest(target_id=stale or "none")).ok
    assert not world.controller.goals
    assert world.dialogue.confirm(ConfirmRequest(target_id=world.shown)).ok
    assert len(world.controller.goals) == 1


def test_an_unsure_yes_is_asked_about() -> None:
    world = World(select=["prediction", ("confirmation", 0.6)], **first_words())
    world.say(FIRST)
    turn = world.say("hmm right")
    assert not turn.ok
    assert "yes" in turn.reply
    assert not world.controller.goals


@pytest.mark.parametrize(
    "text",
    [
        "yeah, good, but bring it down",
        "Yes if you stay off the rim",
        "fine, 2 cm lower",
        "yes a bit to the right",
        "yes, left",
        "No!",
        "don't go there",
    ],
)
def test_a_yes_that_asks_for_more_is_asked_about_however_sure_the_model_is(text: str) -> None:
    world = World(select=["prediction", ("confirmation", 0.99)], **first_words())
    world.say(FIRST)
    turn = world.say(text)
    assert not turn.ok
    assert "Did you mean yes?" in turn.reply
    assert not world.controller.goals


@pytest.mark.parametrize("text", ["that's all right, go there", "yes lean on it, please"])
def test_a_plain_yes_in_more_words_is_a_yes(text: str) -> None:
    world = World(select=["prediction", ("confirmation", 0.99)], **first_words())
    world.say(FIRST)
    assert world.say(text).ok
    assert world.controller.goals


def test_confirm_without_any_target_says_what_to_do() -> None:
    world = World()
    turn = world.dialogue.confirm(ConfirmRequest(target_id="target-x-1"))
    assert not turn.ok
    assert "no target yet" in turn.reply


def test_what_is_not_in_the_picture_is_named() -> None:
    world = World(analyze=[{"position": "absolute", "objects": ["4-4"]}])
    turn = world.say("lean on the violin")
    assert not turn.ok
    assert "I don't see a 'violin'" in turn.reply
    assert turn.target is None


def test_an_instruction_without_object_gets_a_question() -> None:
    world = World(analyze=[{"position": "absolute", "objects": []}])
    turn = world.say("lean over there")
    assert not turn.ok
    assert "Name something" in turn.reply


@pytest.mark.parametrize(
    "garbage",
    [
        None,
        "prose",
        42,
        [],
        {"position": "absolute"},
        {"position": "on", "objects": ["9-9"]},
        {"position": "absolute", "objects": ["9"]},
        {"position": "absolute", "objects": ["0-3"]},
        {"position": "absolute", "objects": ["3-2"]},
        {"position": "absolute", "objects": ["9-10"]},
        {"position": "absolute", "objects": ["99999999999-1"]},
        {"position": "absolute", "objects": ["-"]},
        {"position": "absolute", "objects": ["1-1"] * 4},
        {"position": "absolute", "objects": [9]},
    ],
)
def test_a_garbled_analysis_is_a_refusal(garbage: object) -> None:
    world = World(analyze=[garbage])
    turn = world.say(FIRST)
    assert not turn.ok
    assert "Nothing changed" in turn.reply


@pytest.mark.parametrize(
    "garbage",
    [
        {"x": "__import__('os')", "y": "1"},
        {"x": "1/0", "y": "1"},
        {"x": "1e999", "y": "1"},
        {"x": "9" * 50, "y": "1"},
        {"x": "b.left", "y": "a.v"},
        {"x": "", "y": "1"},
        {"x": 12, "y": 13},
        {"x": "1" * 5000, "y": "1"},
        {"y": "1"},
    ],
)
def test_a_garbled_point_is_a_refusal_and_the_target_stays(garbage: object) -> None:
    world = World(select=["prediction", "correction"], correct=[garbage], **first_words())
    world.say(FIRST)
    before = world.shown
    turn = world.say("to the left")
    assert not turn.ok
    assert turn.target is None
    assert world.dialogue.confirm(ConfirmRequest(target_id=before)).ok


@pytest.mark.parametrize(
    "error", [UnavailableError("nobody"), DeadlineError("late"), ModelError("broken")]
)
@pytest.mark.parametrize("task", ["select", "analyze", "effector"])
def test_a_dead_language_model_moves_nothing(task: str, error: Exception) -> None:
    world = World(**{**first_words(), task: [error]})
    turn = world.say(FIRST)
    if task == "effector":
        turn = world.dialogue.confirm(ConfirmRequest(target_id=world.shown))
    assert not turn.ok
    assert turn.retryable == (not isinstance(error, ModelError)), "the same words fail again"
    assert "Nothing changed" in turn.reply
    assert not world.controller.goals


def test_dead_grounding_and_perception_are_told_apart() -> None:
    world = World(**first_words())
    world.grounding.error = UnavailableError("nobody serves grounding")
    assert "grounding service cannot be asked now" in world.say(FIRST).reply
    world.grounding.error = None
    world.lift.error = UnavailableError("nobody serves perception")
    turn = world.say(FIRST)
    assert turn.ok
    assert "Perception does not answer" in turn.reply
    assert turn.target is not None
    assert turn.target.point is None
    turn = world.dialogue.confirm(ConfirmRequest(target_id=world.shown))
    assert not turn.ok
    assert "perception cannot be asked now" in turn.reply
    world.lift.error = None
    assert world.dialogue.confirm(ConfirmRequest(target_id=world.shown)).ok


def test_a_target_on_the_sky_is_shown_and_not_confirmed() -> None:
    world = World(**first_words())
    world.lift.error = RefusedError("no depth at (500, 360)")
    turn = world.say(FIRST)
    assert turn.target is not None
    assert "no depth" in turn.target.warning
    turn = world.dialogue.confirm(ConfirmRequest(target_id=world.shown))
    assert not turn.ok
    assert "no depth" in turn.reply
    assert not world.controller.goals


def test_a_refusal_of_the_controller_reaches_the_operator_and_leaves_the_target() -> None:
    world = World(**first_words())
    world.say(FIRST)
    world.controller.refusal = "left_foot carries the robot"
    turn = world.dialogue.confirm(ConfirmRequest(target_id=world.shown))
    assert not turn.ok
    assert "left_foot carries the robot" in turn.reply
    world.controller.refusal = ""
    assert world.dialogue.confirm(ConfirmRequest(target_id=world.shown)).ok


def test_a_point_no_robot_can_mean_is_refused() -> None:
    world = World(**first_words())
    world.grounding.things["book"] = (12, 300, 16, 320)
    world.lift.reach = 30.0
    world.say(FIRST)
    turn = world.dialogue.confirm(ConfirmRequest(target_id=world.shown))
    assert not turn.ok
    assert "cannot go to that point" in turn.reply
    assert not world.controller.goals


@pytest.mark.parametrize(("u", "hand"), [(300, "left_hand"), (900, "right_hand")])
def test_no_hand_named_takes_the_one_on_that_side_and_says_so(u: float, hand: str) -> None:
    world = World(effector=[{"effector": "unspecified", "task": "contact"}], **first_words())
    world.grounding.things["book"] = (u - 10, 300, u + 10, 320)
    world.say(FIRST)
    turn = world.dialogue.confirm(ConfirmRequest(target_id=world.shown))
    assert turn.end_effector == hand
    assert "You named no hand" in turn.reply


@pytest.mark.parametrize(
    ("state", "reason"), [("unreachable", "0.12 m short"), ("aborted", "stopped")]
)
def test_a_goal_that_fails_is_told_with_its_reason(state: str, reason: str) -> None:
    world = World(**first_words())
    world.say(FIRST)
    goal_id = world.dialogue.confirm(ConfirmRequest(target_id=world.shown)).goal_id
    assert world.event("another", state) is None
    turn = world.event(goal_id, state, reason=reason)
    assert turn is not None
    assert not turn.ok
    assert reason in turn.reply
    assert turn.target is not None
    assert turn.target.state == "abandoned"
    assert world.say(FIRST).ok


def test_stop_works_with_every_model_dead_and_tells_when_it_did_not() -> None:
    dead = UnavailableError("dead")
    world = World(select=[dead], analyze=[dead])
    assert world.say("stop").ok
    world.controller.stop_error = UnavailableError("robot gone")
    turn = world.say("robot, STOP!!")
    assert not turn.ok
    assert "NOT ACKNOWLEDGED" in turn.reply


@pytest.mark.parametrize(
    "text",
    [
        "stop",
        "STOP!",
        "please stop",
        "stop now",
        "halt",
        "Freeze.",
        "robot stop",
        "stop stop stop stop STOP",
        "no no no, stop it right now",
        "oh please just stop everything at once",
    ],
)
def test_stop_words(text: str) -> None:
    assert is_stop(text)


@pytest.mark.parametrize(
    "text", ["stop there, that's perfect", "put your hand on the stop sign", "", "yes"]
)
def test_no_stop_words(text: str) -> None:
    assert not is_stop(text)


def test_a_correction_without_history_says_so() -> None:
    world = World(
        select=["prediction", "correction"],
        correct=[{"x": "target.u+2*last.du", "y": "target.v"}],
        **first_words(),
    )
    world.say(FIRST)
    turn = world.say("twice as much")
    assert not turn.ok
    assert "earlier move" in turn.reply


def test_undo_can_be_said_twice() -> None:
    undo = {"x": "target.u-last.du", "y": "target.v-last.dv"}
    moves = [
        {"x": "target.u+100", "y": "target.v"},
        {"x": "target.u", "y": "target.v-40"},
        undo,
        undo,
    ]
    world = World(select=["prediction", "correction"], correct=moves, **first_words())
    world.say(FIRST)
    points = []
    for text in ("a lot right", "up", "undo", "undo"):
        turn = world.say(text)
        assert turn.target is not None
        points.append((turn.target.u, turn.target.v))
    assert points == [(600, 360), (600, 320), (600, 360), (500, 360)]


def test_what_a_model_takes_back_in_numbers_is_forgotten_too() -> None:
    moves = [
        {"x": "500+100", "y": "360"},
        {"x": "600", "y": "360-40"},
        {"x": "600", "y": "320+40"},
        {"x": "target.u-last.du", "y": "target.v-last.dv"},
    ]
    world = World(select=["prediction", "correction"], correct=moves, **first_words())
    world.say(FIRST)
    points = []
    for text in ("a lot right", "up", "back where it was, please", "undo"):
        turn = world.say(text)
        assert turn.target is not None
        points.append((turn.target.u, turn.target.v))
    assert points == [(600, 360), (600, 320), (600, 360), (500, 360)]


def test_a_move_as_long_as_the_last_one_takes_nothing_back() -> None:
    moves = [
        {"x": "target.u+40", "y": "target.v"},
        {"x": "target.u-40", "y": "target.v"},
        {"x": "target.u+last.du", "y": "target.v+last.dv"},
    ]
    world = World(select=["prediction", "correction"], correct=moves, **first_words())
    world.say(FIRST)
    turns = [world.say(text) for text in ("right", "left", "the same again")]
    assert turns[-1].target is not None
    assert turns[-1].target.u == 460


def test_a_rejection_without_direction_leaves_the_target() -> None:
    world = World(select=["prediction", "correction"], correct=[STAY], **first_words())
    world.say(FIRST)
    turn = world.say("no")
    assert not turn.ok
    assert "stays" in turn.reply


def test_a_point_outside_is_clipped_and_said() -> None:
    world = World(
        select=["prediction", "correction"],
        correct=[{"x": "target.u-9000", "y": "target.v"}],
        **first_words(),
    )
    world.say(FIRST)
    turn = world.say("9000 pixels left")
    assert turn.target is not None
    assert 0 <= turn.target.u <= 2
    assert "outside the picture" in turn.reply


def test_objects_of_a_correction_are_looked_for() -> None:
    world = World(
        select=["prediction", "correction"],
        objects=[{"objects": ["4-4"]}],
        correct=[{"x": "target.u+0.5*(a.u-target.u)", "y": "target.v"}],
        **first_words(),
    )
    world.say(FIRST)
    turn = world.say("closer to the cup")
    assert world.model.last_question("correct") == "past none, A right\ncloser to the A"
    assert turn.target is not None
    assert turn.target.u == pytest.approx(500 + 0.5 * (930 - 500))
    assert turn.target.phrases == ["cup"]


def test_an_utterance_belongs_to_the_picture_the_operator_saw() -> None:
    world = World(**first_words())
    world.add_frame(200)
    world.say(FIRST, stamp_ns=100)
    assert world.grounding.asked[-1][0] == 100
    assert world.lift.asked[-1][2] == 100
    turn = world.say(FIRST, stamp_ns=150)
    assert not turn.ok
    assert "150" in turn.reply


def test_a_correction_in_a_newer_picture_starts_from_the_reprojected_point() -> None:
    world = World(
        select=["prediction", "correction"],
        correct=[{"x": "target.u+40", "y": "target.v"}],
        **first_words(),
    )
    world.add_view(100)
    world.say(FIRST)
    world.add_frame(200)
    world.add_view(200, x=0.08)
    turn = world.say("right", stamp_ns=200)
    assert turn.target is not None
    assert turn.target.frame_stamp_ns == 200
    # The fake's point is (0.6, 0.14, 0.8) in the world, and the camera moved by 0.08 along x.
    assert turn.target.u == pytest.approx(800 * (0.6 - 0.08) / 0.8 + 640 + 40)


def test_no_picture_at_all_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("w2c_dialogue.pipeline.FRAME_WAIT_S", 0.01)
    world = World(**first_words())
    world.dialogue._frames = FrameStore()
    assert "camera does not send" in world.say(FIRST).reply


def test_a_click_shows_a_target_that_can_be_confirmed() -> None:
    world = World()
    turn = world.dialogue.point(PointRequest(u=700, v=300, end_effector="left_hand", task="reach"))
    assert turn.module == "point"
    assert turn.target is not None
    turn = world.dialogue.confirm(ConfirmRequest(target_id=turn.target.target_id))
    assert (turn.end_effector, turn.task) == ("left_hand", "reach")
    assert not world.model.questions


def test_a_named_foot_is_passed_on_and_stands() -> None:
    world = World()
    turn = world.dialogue.point(PointRequest(u=700, v=300, end_effector="left_foot", task="reach"))
    assert turn.target is not None
    turn = world.dialogue.confirm(ConfirmRequest(target_id=turn.target.target_id))
    assert (turn.end_effector, turn.task) == ("left_foot", "contact")
    assert "step there with my left foot" in turn.reply
    assert [goal.end_effector for goal in world.controller.goals] == ["left_foot"]


def test_a_click_outside_is_refused() -> None:
    turn = World().dialogue.point(PointRequest(u=1300, v=300))
    assert not turn.ok
    assert "outside" in turn.reply


def test_a_stop_during_a_confirmation_keeps_the_robot_still() -> None:
    world = World(**first_words())
    world.say(FIRST)
    ask = world.model.complete

    def stop_meanwhile(question: object) -> object:
        world.dialogue.say(SayRequest(text="stop"))
        return ask(question)  # type: ignore[arg-type]

    world.model.complete = stop_meanwhile  # type: ignore[method-assign]
    turn = world.dialogue.confirm(ConfirmRequest(target_id=world.shown))
    assert not turn.ok
    assert not world.controller.goals


@pytest.mark.parametrize("text", [" ", "...", "\x00\x01", "word " * 61])
def test_no_words_or_too_many_are_refused_politely(text: str) -> None:
    world = World()
    turn = world.say(text)
    assert not turn.ok
    assert not world.model.questions


def test_a_goal_carries_what_the_newest_picture_shows() -> None:
    world = World(**first_words())
    world.say(FIRST)
    assert world.dialogue.confirm(ConfirmRequest(target_id=world.shown)).ok
    (goal,) = world.controller.goals
    assert goal.obstacles is not None
    assert world.lift.heights_of == [goal.obstacles.stamp_ns]


def test_without_heights_the_goal_goes_without_and_the_log_says_so(
    caplog: pytest.LogCaptureFixture,
) -> None:
    world = World(**first_words())
    world.say(FIRST)
    world.lift.heights_error = DeadlineError("perception/heights: no reply within 2 s")
    assert world.dialogue.confirm(ConfirmRequest(target_id=world.shown)).ok
    assert world.controller.goals[0].obstacles is None
    assert "without obstacles" in caplog.text


def test_a_support_that_cannot_be_leaned_on_is_refused_with_the_reason() -> None:
    world = World(**first_words())
    world.say(FIRST)
    world.controller.outlook = PreviewReply(
        reachable=False, distance=0.2, reason="the right hand ends 20.0 cm short of the point"
    )
    turn = world.dialogue.confirm(ConfirmRequest(target_id=world.shown))
    assert not turn.ok
    assert "cannot lean there: the right hand ends 20.0 cm short" in turn.reply
    assert not world.controller.goals
    world.controller.outlook = PreviewReply(reachable=True, distance=0.0)
    assert world.dialogue.confirm(ConfirmRequest(target_id=world.shown)).ok


def test_a_reach_that_ends_short_goes_as_near_as_it_can_and_says_so() -> None:
    task = [{"effector": "left_hand", "task": "reach"}]
    world = World(**{**first_words(), "effector": task})
    world.say(FIRST)
    world.controller.outlook = PreviewReply(
        reachable=False, distance=0.06, reason="the left hand ends 6.0 cm short of the point"
    )
    turn = world.dialogue.confirm(ConfirmRequest(target_id=world.shown))
    assert turn.ok
    assert "I do not expect to get there: the left hand ends 6.0 cm short" in turn.reply
    assert len(world.controller.goals) == 1


def test_what_to_beware_of_is_told_with_the_confirmation() -> None:
    world = World(**first_words())
    world.say(FIRST)
    world.controller.outlook = PreviewReply(
        reachable=True, distance=0.0, reason="the robot leans 9.0 cm ahead of its feet"
    )
    turn = world.dialogue.confirm(ConfirmRequest(target_id=world.shown))
    assert turn.ok
    assert "Beware: the robot leans 9.0 cm ahead of its feet." in turn.reply
    assert len(world.controller.goals) == 1


def test_a_preview_that_does_not_come_holds_nothing_up() -> None:
    world = World(**first_words())
    world.say(FIRST)
    world.controller.preview_error = UnavailableError("the search is still starting")
    turn = world.dialogue.confirm(ConfirmRequest(target_id=world.shown))
    assert turn.ok
    assert len(world.controller.goals) == 1


def test_a_blocked_way_is_told_as_the_controller_tells_it() -> None:
    world = World(**first_words())
    world.say(FIRST)
    world.controller.refusal = "the way is blocked by something 1.20 m high at x 0.50, y -0.10 m"
    turn = world.dialogue.confirm(ConfirmRequest(target_id=world.shown))
    assert not turn.ok
    assert "blocked by something 1.20 m high" in turn.reply
