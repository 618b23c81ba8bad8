"""The dialogue asks where words leave a choice, and goes on from a short answer."""

from typing import Any

import pytest

from support.conversing import CUP, FIRST, World, first_words
from w2c.errors import UnavailableError
from w2c.messages import ConfirmRequest, PointRequest

TWO_CUPS = [CUP, (100, 200, 160, 280)]
CUP_WORDS: dict[str, Any] = {"analyze": [{"position": "absolute", "objects": ["4-4"]}]}
NEXT_TO: dict[str, Any] = {
    "analyze": [{"position": "relative", "objects": ["5-5"]}],
    "relative": [{"x": "a.left-0.5*a.width", "y": "a.v"}],
}
UNSURE = {"prediction": 0.5, "correction": 0.4, "confirmation": 0.1}


def asked_about_cups(**answers: Any) -> World:
    world = World(**{**CUP_WORDS, **answers})
    world.grounding.things["cup"] = TWO_CUPS
    turn = world.say("lean on the cup")
    assert not turn.ok
    assert turn.module == "question"
    assert turn.options == ["left", "right"]
    assert "Which 'cup' do you mean: left or right?" in turn.reply
    assert turn.target is None
    return world


@pytest.mark.parametrize(("answer", "u"), [("the left one", 130), ("on the right", 930)])
def test_two_things_of_one_name_are_asked_about(answer: str, u: float) -> None:
    world = asked_about_cups()
    questions = len(world.model.questions)
    turn = world.say(answer)
    assert turn.ok
    assert turn.module == "prediction.absolute"
    assert turn.target is not None
    assert (turn.target.u, turn.target.v) == (u, 240)
    assert turn.target.instruction == "lean on the cup"
    assert [box.left for box in turn.target.boxes] == [u - 30]
    assert len(world.model.questions) == questions, "nothing is asked twice"
    assert not world.controller.goals
    assert world.dialogue.confirm(ConfirmRequest(target_id=world.shown)).ok


def test_a_place_beside_one_of_two_things_is_asked_about() -> None:
    world = World(**NEXT_TO)
    world.grounding.things["cup"] = TWO_CUPS
    assert world.say("hand left of the cup").module == "question"
    turn = world.say("the left one")
    assert turn.module == "prediction.relative"
    assert turn.target is not None
    assert (turn.target.u, turn.target.v) == pytest.approx((70, 253.6))


def test_a_correction_towards_one_of_two_things_is_asked_about() -> None:
    world = World(
        select=["prediction", "correction"],
        objects=[{"objects": ["4-4"]}],
        correct=[{"x": "a.u", "y": "target.v"}],
        **first_words(),
    )
    world.grounding.things["cup"] = TWO_CUPS
    world.say(FIRST)
    before = world.shown
    assert world.say("closer to the cup").module == "question"
    assert world.dialogue.shown() is not None
    turn = world.say("left")
    assert turn.module == "correction"
    assert turn.target is not None
    assert (turn.target.u, turn.target.corrections) == (130, 1)
    assert turn.target.target_id != before


def test_a_name_that_says_which_is_not_asked_about() -> None:
    world = World(analyze=[{"position": "absolute", "objects": ["4-5"]}])
    world.grounding.things["left cup"] = TWO_CUPS
    turn = world.say("lean on the left cup")
    assert turn.ok
    assert turn.target is not None
    assert turn.target.u == 130


def test_both_of_two_names_are_asked_about_one_after_the_other() -> None:
    world = World(
        analyze=[{"position": "relative", "objects": ["3-3", "6-6"]}],
        relative=[{"x": "(a.u+b.u)/2", "y": "a.v"}],
    )
    world.grounding.things.update(cup=TWO_CUPS, book=[(0, 0, 40, 40), (0, 400, 40, 440)])
    assert "'cup'" in world.say("between the cup and the book").reply.replace("'cup,'", "'cup'")
    turn = world.say("right")
    assert turn.options == ["upper", "lower"]
    turn = world.say("the lower one")
    assert turn.target is not None
    assert turn.target.u == (930 + 20) / 2


def test_another_instruction_instead_of_an_answer_is_taken() -> None:
    world = asked_about_cups(analyze=[*CUP_WORDS["analyze"], *first_words()["analyze"]])
    turn = world.say(FIRST)
    assert turn.ok
    assert turn.target is not None
    assert turn.target.phrases == ["book"]
    world.model.answers["analyze"] = [{"position": "absolute", "objects": []}]
    assert "Which" not in world.say("the left one").reply, "the question is over"


def test_a_click_answers_too() -> None:
    world = asked_about_cups()
    assert world.dialogue.point(PointRequest(u=130, v=240)).ok
    assert world.dialogue._asking.pending is None


def test_what_leads_nowhere_leaves_the_question_open() -> None:
    world = asked_about_cups()
    world.model.answers["analyze"] = [{"position": "absolute", "objects": []}]
    turn = world.say("hm well")
    assert "Still open: Which 'cup'" in turn.reply
    world.lift.error = None
    assert world.say("left").ok


def test_a_dead_service_leaves_the_question_open() -> None:
    world = World(**NEXT_TO)
    world.grounding.things["cup"] = TWO_CUPS
    world.say("hand left of the cup")
    world.model.answers["relative"] = [UnavailableError("nobody"), NEXT_TO["relative"][0]]
    turn = world.say("left")
    assert not turn.ok
    assert turn.retryable
    assert "Still open" in turn.reply
    assert world.say("left").ok


def test_an_answer_after_the_picture_is_gone_is_refused() -> None:
    world = asked_about_cups()
    for stamp in range(101, 202):
        world.add_frame(stamp)
    turn = world.say("left")
    assert (turn.ok, turn.retryable) == (False, False), "no picture comes back"
    assert "Name the place again" in turn.reply


def test_a_correction_whose_target_changed_meanwhile_is_refused() -> None:
    world = World(
        select=["prediction", "correction"],
        objects=[{"objects": ["4-4"]}],
        correct=[{"x": "a.u", "y": "target.v"}],
        **first_words(),
    )
    world.grounding.things["cup"] = TWO_CUPS
    world.say(FIRST)
    world.say("closer to the cup")
    world.dialogue._conversation.abandon_shown("gone")
    turn = world.say("left")
    assert not turn.ok
    assert "changed meanwhile" in turn.reply


def test_never_mind_drops_a_question() -> None:
    world = asked_about_cups()
    turn = world.say("never mind")
    assert turn.ok
    assert "dropped the question" in turn.reply
    assert world.dialogue._asking.pending is None


def test_never_mind_drops_a_question_before_it_holds_a_motion() -> None:
    world = World(**first_words())
    world.say(FIRST)
    assert world.dialogue.confirm(ConfirmRequest(target_id=world.shown)).ok
    world.grounding.things["book"] = TWO_CUPS
    assert world.say(FIRST).module == "question"
    assert world.say("never mind").ok
    assert not world.controller.stops
    world.say("never mind")
    assert len(world.controller.stops) == 1


def unsure_world(probabilities: dict[str, float]) -> World:
    world = World(
        select=["prediction", probabilities],
        correct=[{"x": "target.u-20", "y": "target.v"}],
        **first_words(),
    )
    world.say(FIRST)
    return world


@pytest.mark.parametrize(
    ("answer", "module"),
    [("a new place", "prediction.absolute"), ("change it please", "correction")],
)
def test_an_unsure_selector_asks_and_understands_the_answer(answer: str, module: str) -> None:
    world = unsure_world(UNSURE)
    before = world.shown
    turn = world.say(FIRST)
    assert not turn.ok
    assert turn.module == "question"
    assert turn.options == ["new place", "change"]
    assert world.shown == before
    turn = world.say(answer)
    assert turn.ok
    assert turn.module == module


def test_a_near_yes_is_asked_about_and_moves_nothing() -> None:
    world = unsure_world({"correction": 0.5, "confirmation": 0.45, "prediction": 0.05})
    turn = world.say("hmm that's nearly right")
    assert not turn.ok
    assert "Did you mean yes?" in turn.reply
    assert not world.controller.goals


def test_a_clear_selector_asks_nothing() -> None:
    world = unsure_world({"correction": 0.6, "prediction": 0.3, "confirmation": 0.1})
    assert world.say("left").module == "correction"


def test_a_yes_to_a_question_does_not_go_to_the_target_of_before() -> None:
    world = World(select=["prediction", "prediction", "confirmation"], **first_words())
    world.say(FIRST)
    seen = world.shown
    world.grounding.things["book"] = TWO_CUPS
    assert world.say(FIRST).module == "question"
    turn = world.say("yes please", target_id=seen)
    assert not turn.ok
    assert "I asked you something" in turn.reply
    assert "Still open: Which 'book'" in turn.reply
    assert not world.controller.goals
    assert world.dialogue.confirm(ConfirmRequest(target_id=seen)).ok


def test_without_the_unknown_word_is_suggested() -> None:
    world = World(analyze=[{"position": "absolute", "objects": ["4-5"]}])
    turn = world.say("lean on the big violin")
    assert "I do not know the word 'violin'" in turn.reply
    assert "Without that it is 'big'" in turn.reply
