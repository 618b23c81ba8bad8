"""A turn holds what its point was made from: answers as written, probabilities, boxes, models."""

import msgspec
import pytest

from support.conversing import CUP, FIRST, World, first_words
from w2c.bus.codec import decode_message, encode_message
from w2c.errors import UnavailableError
from w2c.messages import ConfirmRequest, Evidence, Turn
from w2c_dialogue.on_surface import SURFACES, THINGS
from w2c_dialogue.trail import LONGEST_ANSWER


def evidence(turn: Turn) -> Evidence:
    assert turn.evidence is not None
    return turn.evidence


def answers(turn: Turn) -> dict[str, str]:
    return {answer.task: answer.answer for answer in evidence(turn).answers}


def test_a_prediction_can_be_explained_afterwards() -> None:
    world = World(
        analyze=[{"position": "relative", "objects": ["5-5"]}],
        relative=[{"x": "a.left-0.5*a.width", "y": "a.v"}],
    )
    turn = world.say("hand left of the cup")
    again = decode_message(encode_message(turn), Turn)
    found = evidence(again)
    assert (found.prompts, found.vision_model) == ("embedded", "known things")
    assert [answer.task for answer in found.answers] == ["select", "analyze", "relative"]
    assert {answer.model for answer in found.answers} == {"scripted"}
    assert found.answers[0].probabilities == {"prediction": 0.99}
    assert msgspec.json.decode(answers(again)["relative"])["x"] == "a.left-0.5*a.width"
    sighting, *rest = found.sightings
    assert tuple(one.phrase for one in rest) == SURFACES + THINGS
    assert not any(one.found for one in rest)
    assert (sighting.phrase, sighting.found, len(sighting.boxes)) == ("cup", True, 1)
    assert again.target is not None
    assert again.target.boxes[0].left == sighting.boxes[0].left == CUP[0]
    assert found.corrected_from is None


def test_a_correction_tells_where_it_began() -> None:
    world = World(
        select=["prediction", "correction"],
        correct=[{"x": "target.u-20", "y": "target.v"}],
        **first_words(),
    )
    world.say(FIRST)
    turn = world.say("left")
    assert evidence(turn).corrected_from == (500, 360)
    assert "target.u-20" in answers(turn)["correct"]


@pytest.mark.parametrize("value", [{"x": "1/0", "y": "1"}, "prose", None])
def test_what_was_refused_is_kept_too(value: object) -> None:
    world = World(select=["prediction", "correction"], correct=[value], **first_words())
    world.say(FIRST)
    turn = world.say("left")
    assert not turn.ok
    assert answers(turn)["correct"] == msgspec.json.encode(value).decode()


def test_an_endless_answer_is_cut() -> None:
    world = World(select=["prediction", "correction"], correct=["9" * 9999], **first_words())
    world.say(FIRST)
    assert len(answers(world.say("left"))["correct"]) == LONGEST_ANSWER


def test_what_was_not_found_is_kept() -> None:
    world = World(analyze=[{"position": "absolute", "objects": ["4-4"]}])
    (sighting,) = evidence(world.say("lean on the violin")).sightings
    assert (sighting.found, sighting.unknown_words) == (False, ["violin"])


def test_an_answer_to_a_question_brings_what_was_found_before() -> None:
    world = World(analyze=[{"position": "absolute", "objects": ["4-4"]}])
    world.grounding.things["cup"] = [CUP, (100, 200, 160, 280)]
    asked = evidence(world.say("lean on the cup"))
    found = evidence(world.say("the left one"))
    assert [answer.task for answer in found.answers] == ["select", "analyze"]
    assert [len(sighting.boxes) for sighting in found.sightings] == [2]
    assert len(asked.answers) == 2, "the evidence of the question is as it was"


def test_where_nobody_was_asked_there_is_none() -> None:
    world = World(**first_words())
    assert world.say("stop").evidence is None
    assert world.dialogue.confirm(ConfirmRequest(target_id="t")).evidence is None
    world.model.answers["select"] = [UnavailableError("nobody")]
    assert world.say(FIRST).evidence is None
