"""Corrections and new places while the robot moves: shown at once, gone to after a yes only."""

import threading
from typing import Any

import numpy as np
import pytest

from support.conversing import FIRST, World, first_words
from w2c.messages import ConfirmRequest, PointRequest, Turn
from w2c_dialogue.cancel_words import is_cancel

LEFT = {"x": "target.u-20", "y": "target.v"}
WORDS = {"analyze": [{"position": "absolute", "objects": ["4-4"]}]}


class MovingWorld(World):
    """The right hand is on its way to the book."""

    def __init__(self, **answers: object) -> None:
        effector = {"effector": "unspecified", "task": "contact"}
        super().__init__(
            **{
                **first_words(),
                "select": ["prediction", "correction"],
                "correct": [LEFT],
                "effector": [effector],
                **answers,  # type: ignore[arg-type]
            }
        )
        self.grounding.things["book"] = (690, 300, 710, 420)
        self.say(FIRST)
        self.first = self.confirm(self.shown)
        assert self.first.ok

    def confirm(self, target_id: str) -> Turn:
        turn = self.dialogue.confirm(ConfirmRequest(target_id=target_id))
        if turn.ok:
            self.shown = ""
        return turn


def test_a_correction_is_shown_and_moves_nothing_before_a_yes() -> None:
    world = MovingWorld()
    turn = world.say("a bit to the left")
    assert turn.ok
    assert turn.target is not None
    assert (turn.target.u, turn.target.state, turn.target.corrections) == (680, "proposed", 1)
    assert "goes on to the old target" in turn.reply
    assert len(world.controller.goals) == 1

    turn = world.confirm(world.shown)
    assert turn.ok
    assert "turn to the new target" in turn.reply
    old, new = world.controller.goals
    assert new.goal_id != old.goal_id
    assert (new.end_effector, new.task) == (old.end_effector, old.task)
    np.testing.assert_allclose(new.point, [0.6, (640 - 680) / 1000, 0.8])


def test_corrections_of_a_moving_target_add_up_and_can_be_undone() -> None:
    undo = {"x": "target.u-last.du", "y": "target.v-last.dv"}
    world = MovingWorld(correct=[LEFT, LEFT, undo, undo])
    points = []
    for text in ("left", "left", "undo", "undo"):
        turn = world.say(text)
        assert turn.target is not None
        points.append(turn.target.u)
    assert points == [680, 660, 680, 700]
    assert len(world.controller.goals) == 1


def test_the_same_hand_goes_on_though_the_point_is_on_the_other_side_now() -> None:
    world = MovingWorld(correct=[{"x": "300", "y": "target.v"}])
    assert world.controller.goals[0].end_effector == "right_hand"
    world.say("far to the left")
    assert world.confirm(world.shown).end_effector == "right_hand"


def test_the_same_hand_goes_on_though_the_motion_ended_meanwhile() -> None:
    world = MovingWorld(correct=[{"x": "300", "y": "target.v"}])
    world.say("far to the left")
    world.event(world.first.goal_id, "loaded")
    assert world.confirm(world.shown).end_effector == "right_hand"


def test_a_goal_is_not_given_up_while_a_long_turn_holds_back_its_events() -> None:
    world = MovingWorld()
    goal_id = world.first.goal_id
    with world.dialogue._turn:
        assert world.dialogue.lose_goal(goal_id, "silent") is None
        assert world.dialogue.lose_robot() is None
    assert world.event(goal_id, "loaded") is not None
    assert world.dialogue.lose_goal(goal_id, "silent") is None


def test_each_turn_tells_the_state_of_the_conversation() -> None:
    world = World(**{**first_words(), "select": ["prediction", "correction"], "correct": [LEFT]})
    states = [world.say("stop").state, world.say(FIRST).state]
    goal = world.dialogue.confirm(ConfirmRequest(target_id=world.shown))
    states += [goal.state, world.say("left").state]
    assert states == ["idle", "target_shown", "moving", "moving"]
    done = world.event(goal.goal_id, "loaded")
    assert done is not None
    assert done.state == "target_shown"
    assert world.say("never mind").state == "in_contact"
    world.event("some-release", "released")
    assert world.say("stop").state == "idle"


@pytest.mark.parametrize(
    ("task", "end", "state"),
    [
        ("reach", "reached", "reached"),
        ("contact", "aborted", "idle"),
        ("contact", "loaded", "idle"),
    ],
)
def test_where_a_motion_ends_is_the_state_until_it_is_lost(task: str, end: str, state: str) -> None:
    world = MovingWorld(effector=[{"effector": "right_hand", "task": task}])
    world.event(world.first.goal_id, end, task)
    if end == "loaded":
        world.event(world.first.goal_id, "aborted", reason="contact lost")
    assert world.say("stop").state == state


def test_a_second_yes_does_not_start_a_second_goal() -> None:
    world = MovingWorld(select=["prediction", "confirmation"])
    assert world.first.target is not None
    for turn in (world.say("yes"), world.confirm(world.first.target.target_id)):
        assert not turn.ok
        assert "already" in turn.reply
    assert len(world.controller.goals) == 1


def test_a_yes_to_a_target_that_was_corrected_meanwhile_is_refused() -> None:
    world = MovingWorld()
    world.say("left")
    stale = world.shown
    world.say("left")
    assert not world.confirm(stale).ok
    assert world.first.target is not None
    assert not world.confirm(world.first.target.target_id).ok
    assert len(world.controller.goals) == 1


def test_the_end_of_the_goal_that_was_replaced_is_not_told_as_a_failure() -> None:
    world = MovingWorld()
    world.say("left")
    second = world.confirm(world.shown)
    assert world.event(world.first.goal_id, "aborted", reason="replaced by goal") is None
    done = world.event(second.goal_id, "loaded")
    assert done is not None
    assert done.target is not None
    assert done.target.target_id == (second.target and second.target.target_id)


def test_a_hand_that_touches_lifts_off_first_and_that_is_said() -> None:
    world = MovingWorld()
    world.event(world.first.goal_id, "touched")
    turn = world.say("left")
    assert "lifts off first" in turn.reply
    assert world.confirm(world.shown).ok


def test_a_reach_turns_like_a_contact() -> None:
    world = MovingWorld(effector=[{"effector": "right_hand", "task": "reach"}])
    world.say("left")
    assert world.confirm(world.shown).task == "reach"


def test_a_target_outlives_the_motion_that_went_on_meanwhile() -> None:
    world = MovingWorld()
    world.say("left")
    done = world.event(world.first.goal_id, "loaded")
    assert done is not None
    assert "say yes to go there" in done.reply
    turn = world.confirm(world.shown)
    assert turn.ok
    assert turn.end_effector == "right_hand"


def test_another_place_takes_the_moving_hand_where_none_is_named() -> None:
    world = MovingWorld(select=["prediction"])
    world.grounding.things["book"] = (90, 300, 110, 420)
    world.say(FIRST)
    turn = world.confirm(world.shown)
    assert turn.end_effector == "right_hand"
    assert "which is on its way" in turn.reply


def test_another_hand_is_refused_by_the_controller_and_the_target_stays() -> None:
    world = MovingWorld(effector=[{"effector": "left_hand", "task": "contact"}])
    world.controller.refusal = "the right hand is on its way; wait for it"
    world.say("left")
    shown = world.shown
    assert "wait for it" in world.confirm(shown).reply
    world.controller.refusal = ""
    assert world.confirm(shown).ok


def test_a_click_turns_the_moving_hand() -> None:
    world = MovingWorld(effector=[{"effector": "right_hand", "task": "reach"}])
    turn = world.dialogue.point(PointRequest(u=300, v=300))
    assert turn.target is not None
    assert turn.target.instruction == FIRST
    turn = world.confirm(turn.target.target_id)
    assert (turn.end_effector, turn.task) == ("right_hand", "reach")


def test_stop_holds_whatever_is_shown() -> None:
    world = MovingWorld()
    world.say("left")
    assert world.say("stop!").ok
    assert len(world.controller.stops) == 1
    assert len(world.controller.goals) == 1


@pytest.mark.parametrize("text", ["Stop, you are going to hit the lamp", "no halt that is too far"])
def test_who_begins_with_stop_holds_a_robot_that_moves(text: str) -> None:
    world = MovingWorld()
    asked = len(world.model.questions)
    assert world.say(text).ok
    assert len(world.controller.stops) == 1
    assert len(world.model.questions) == asked, "no model is asked"

    still = World(**first_words())
    still.say(text)
    assert not still.controller.stops


def test_a_correction_of_a_target_of_before_a_restart_is_refused() -> None:
    world = MovingWorld()
    world.frames.current = lambda frame: False  # type: ignore[method-assign]
    turn = world.say("left")
    assert not turn.ok
    assert "started anew" in turn.reply


def test_never_mind_drops_the_target_without_any_model() -> None:
    world = World(**first_words())
    world.say(FIRST)
    shown, asked = world.shown, len(world.model.questions)
    turn = world.say("oh, never mind!")
    assert turn.ok
    assert turn.module == "cancel"
    assert turn.target is not None
    assert (turn.target.target_id, turn.target.state) == (shown, "abandoned")
    assert len(world.model.questions) == asked
    assert not world.dialogue.confirm(ConfirmRequest(target_id=shown)).ok
    assert not world.controller.goals
    assert not world.controller.stops
    assert not world.say("forget it").ok, "there is nothing any more"


def test_never_mind_takes_back_the_newest_first_and_then_holds() -> None:
    world = MovingWorld()
    world.say("left")
    turn = world.say("never mind")
    assert "goes on to the one you confirmed" in turn.reply
    assert not world.controller.stops
    assert world.say("never mind").ok
    assert len(world.controller.stops) == 1, "only the motion was left"


def test_never_mind_during_a_confirmation_keeps_the_robot_still() -> None:
    world = World(**first_words())
    world.say(FIRST)
    choose, before = world.limbs.choose, world.dialogue._stops
    turns: list[Turn] = []
    other = threading.Thread(target=lambda: turns.append(world.say("never mind")))

    def meanwhile(*arguments: Any) -> Any:
        other.start()
        for _ in range(2000):
            if world.dialogue._stops == before:
                other.join(0.001)
        return choose(*arguments)

    world.limbs.choose = meanwhile  # type: ignore[method-assign, assignment]
    assert not world.dialogue.confirm(ConfirmRequest(target_id=world.shown)).ok
    other.join(5.0)
    assert [turn.module for turn in turns] == ["cancel"]
    assert not world.controller.goals


@pytest.mark.parametrize(
    "text", ["never mind", "Nevermind.", "oh no, forget it please", "CANCEL!", "sorry, call it off"]
)
def test_cancel_words(text: str) -> None:
    assert is_cancel(text)


@pytest.mark.parametrize(
    "text",
    ["never mind the cup, take the plate", "cancel that", "drop it a bit", "no", "yes", "", "oh"],
)
def test_no_cancel_words(text: str) -> None:
    assert not is_cancel(text)
