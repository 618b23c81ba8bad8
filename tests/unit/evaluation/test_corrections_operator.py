"""Scripted operators of the correction study: how they talk, look, choose, learn, and give up."""

import re
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from w2c.errors import ConfigError
from w2c.messages import Box, Evidence, Sighting, Turn
from w2c_evaluation.corrections.correcting import Beliefs
from w2c_evaluation.corrections.eye import DOT_PX, ERROR, RING_PX, Eye, Look, Pixel, Thing, distance
from w2c_evaluation.corrections.instructing import Speaking, instructions
from w2c_evaluation.corrections.operator import Operator, Seen
from w2c_evaluation.corrections.saying import Chooser, Saying, spelled
from w2c_evaluation.corrections.trial import MOST_PROMPTS
from w2c_evaluation.corrections.voice import (
    FEWEST_PHRASINGS,
    VOICE_FILES,
    parse_voice,
    read_voice,
    voice_names,
)

BOOK = Thing(
    ("book", "hardcover", "blue book", "blue hardcover"), 2, 500.0, 300.0, 760.0, 480.0, 10.0
)
MUG = Thing(("mug", "red mug"), 1, 900.0, 200.0, 980.0, 290.0, 5.0)
TABLE = Thing(("table",), 1, 0.0, 150.0, 1280.0, 720.0, 8.0, furniture=True)
LOOK = Look(None, (800.0, 420.0), (BOOK, MUG, TABLE), 10.0)
UNSPEAKABLE = re.compile(r"\bpx\b|pixel|coordinate", re.IGNORECASE)


def person(voice: str = "carpenter", *, corrects: bool = True, seed: int = 0) -> Operator:
    return Operator(read_voice(voice), np.random.default_rng(seed), corrects=corrects)


def play(operator: Operator, ring: Pixel, share: float = 1.0) -> tuple[list[Saying], Pixel | None]:
    """Talk to a robot that moves a share of the way that was expected; at most five prompts."""
    dot: Pixel | None = None
    said: list[Saying] = []
    operator.begin()
    while len(said) < MOST_PROMPTS:
        saying = operator.speak(replace(LOOK, dot=dot, ring=ring))
        if saying is None:
            break
        said.append(saying)
        before, dot = dot, saying.lands
        if before is not None and saying.changes:
            dot = (
                before[0] + share * (saying.lands[0] - before[0]),
                before[1] + share * (saying.lands[1] - before[1]),
            )
        operator.hear(saying, before, Seen("", ok=True, dot=dot))
    return said, dot


def rings() -> list[Pixel]:
    rng = np.random.default_rng(4)
    return [(float(rng.uniform(200, 1080)), float(rng.uniform(200, 620))) for _ in range(4)]


def test_there_are_many_voices_and_each_has_its_own_phrasings() -> None:
    assert len(voice_names()) >= 10
    texts: list[str] = []
    for name in voice_names():
        voice = read_voice(name)
        assert voice.phrasings >= FEWEST_PHRASINGS
        groups = msgspec.structs.asdict(voice.instructions) | msgspec.structs.asdict(
            voice.corrections
        )
        texts += {text for group in groups.values() for text in group}
    assert len(set(texts)) >= 0.8 * len(texts)


@pytest.mark.parametrize("name", voice_names())
def test_nobody_speaks_of_pixels_or_coordinates(name: str) -> None:
    for phase in (False, True):
        operator = person(name, corrects=phase)
        for ring in rings():
            for saying in play(operator, ring)[0]:
                assert not UNSPEAKABLE.search(saying.text), saying.text
                assert "{" not in saying.text


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('"Hand on the {thing}."', '"Hand on it."', "expected thing"),
        ('"Undo that."', '"Undo the {thing}."', "expected nothing"),
        ("colour = 0.2", "colour = 2", "colour"),
        ("[words]", "[words]\nlouder = ['!']", "louder"),
    ],
)
def test_a_voice_that_is_wrong_is_refused_with_the_reason(
    old: str, new: str, complaint: str
) -> None:
    text = (VOICE_FILES / "carpenter.toml").read_text()
    assert old in text
    with pytest.raises(ConfigError, match=complaint):
        parse_voice(text.replace(old, new, 1).encode(), "carpenter")


def test_an_unknown_voice_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(ConfigError, match="carpenter"):
        read_voice("nobody")


def test_lengths_are_seen_with_an_error_of_a_quarter_and_places_that_meet_without() -> None:
    eye = Eye(np.random.default_rng(1))
    seen = [eye.offset((0.0, 0.0), (100.0, -200.0)) for _ in range(300)]
    across, down = zip(*seen, strict=True)
    for factors in (np.asarray(across) / 100.0, np.asarray(down) / -200.0):
        assert 1.0 - ERROR <= factors.min() < 0.8
        assert 1.2 < factors.max() <= 1.0 + ERROR
    assert eye.offset((3.0, 4.0), (3.0, 4.0)) == (0.0, 0.0)


def test_a_dot_that_is_wholly_in_the_ring_is_good_enough() -> None:
    u, v = LOOK.ring
    inside = replace(LOOK, dot=(u + RING_PX - DOT_PX, v))
    outside = replace(LOOK, dot=(u + RING_PX - DOT_PX + 0.5, v))
    assert person().speak(inside) is None
    assert person().speak(outside) is not None


@pytest.mark.parametrize("name", voice_names())
def test_who_may_correct_gets_a_literal_robot_into_the_ring(name: str) -> None:
    operator = person(name)
    ends = []
    for ring in rings():
        said, dot = play(operator, ring)
        assert not said[0].changes
        assert dot is not None
        ends.append(distance(dot, ring))
    assert np.median(ends) <= 2.0 * RING_PX


def test_who_does_not_know_of_corrections_only_names_places() -> None:
    for ring in rings():
        said, _ = play(person(corrects=False), ring)
        assert said
        assert not any(saying.changes for saying in said)


def test_an_operator_learns_how_far_words_go() -> None:
    beliefs = Beliefs(np.random.default_rng(0))
    before = beliefs.pixels("small")
    for _ in range(20):
        beliefs.learn("small", beliefs.pixels("small"), 60.0)
    assert beliefs.pixels("small") == pytest.approx(60.0, rel=1e-3)
    assert before != pytest.approx(60.0, rel=0.2)


def test_what_was_learnt_comes_from_the_dot() -> None:
    operator = person()
    start = 700.0, 420.0
    for _ in range(12):
        expected = operator._beliefs.pixels("large")
        lands = start[0] + expected, start[1]
        saying = Saying(
            "a lot right", "amount", "large right", lands, 0.0, belief="large", changes=True
        )
        operator.hear(saying, start, Seen("", ok=True, dot=(start[0] + 50.0, start[1] + 2.0)))
    assert operator._beliefs.pixels("large") == pytest.approx(50.0, rel=0.3)
    # What goes elsewhere says nothing of how far the words go.
    sideways = Seen("", ok=True, dot=(start[0], start[1] + 400.0))
    before = operator._beliefs.pixels("large")
    operator.hear(saying, start, sideways)
    assert operator._beliefs.pixels("large") == before


def test_a_name_that_was_not_found_is_not_said_again() -> None:
    operator = person(corrects=False)
    look = replace(LOOK, things=(MUG,))
    first = operator.speak(look)
    assert first is not None
    operator.hear(first, None, Seen(f"I don't see a '{first.name}'.", ok=False, dot=None))
    names = {saying.name for _ in range(30) if (saying := operator.speak(look)) is not None}
    assert names == set(MUG.names) - {first.name}


def test_words_that_failed_are_not_repeated() -> None:
    operator = person()
    said = set()
    for _ in range(25):
        saying = operator.speak(LOOK)
        if saying is None:
            break
        assert saying.text not in said
        said.add(saying.text)
        operator.hear(saying, None, Seen("I could not follow that.", ok=False, dot=None))


def test_who_cannot_correct_goes_back_to_the_place_that_was_nearer() -> None:
    operator = person(corrects=False)
    first = operator.speak(LOOK)
    assert first is not None
    near = LOOK.ring[0] + 15.0, LOOK.ring[1]
    operator.hear(first, None, Seen("", ok=True, dot=near))
    far = replace(LOOK, dot=(100.0, 160.0))
    assert [one.text for one in operator._again(far)] == [first.text]
    # It says so only because the dot came near: nearer than anything else would.
    assert operator._again(far)[0].leaves <= 15.0 * (1.0 + ERROR)
    assert operator._again(replace(LOOK, dot=near)) == []


def asked(options: list[str], **boxes: list[Box]) -> Turn:
    name, found = next(iter(boxes.items()), ("", []))
    sightings = [Sighting(phrase=name, found=True, score=0.9, boxes=found)] if name else []
    return Turn(
        stamp_ns=1,
        text="",
        module="question",
        reply=f"Which '{name}' do you mean? I see {len(found)} that fit.",
        ok=False,
        options=options,
        seconds=0.1,
        evidence=Evidence(prompts="embedded", sightings=sightings),
    )


def box_of(thing: Thing) -> Box:
    return Box(left=thing.left, top=thing.top, right=thing.right, bottom=thing.bottom, score=0.9)


SAID = Saying("Hand on the mug.", "on", "on mug", MUG.centre, 0.0, thing=MUG, name="mug")


def test_a_question_is_answered_with_the_thing_that_was_named() -> None:
    other = Box(left=100.0, top=210.0, right=180.0, bottom=300.0, score=0.9)
    turn = asked(["left", "right"], mug=[other, box_of(MUG)])
    answer = person().answer(turn, SAID)
    assert answer is not None
    assert "right" in answer
    assert "left" not in answer


def test_new_place_or_change_is_answered_by_what_was_said() -> None:
    turn = asked(["new place", "change"])
    assert person().answer(turn, SAID) == "new place"
    assert person().answer(turn, replace(SAID, changes=True)) == "change"


def test_a_question_is_dropped_only_where_no_dot_would_be_lost() -> None:
    operator = person()
    assert {operator.drop(replace(LOOK, dot=(1.0, 1.0))) for _ in range(30)} == {None}
    words = {operator.drop(LOOK) for _ in range(30)} - {None}
    assert words
    assert words <= set(read_voice("carpenter").words.cancel)


def test_centimetres_are_as_long_as_they_look_at_the_thing_that_is_named() -> None:
    look = replace(LOOK, ring=(800.0, 245.0), things=(MUG,))
    speaking = Speaking(
        read_voice("carpenter"),
        look,
        Eye(np.random.default_rng(0), 0.0),
        Chooser(np.random.default_rng(0)),
    )
    texts = {one.text for one in instructions(speaking) if one.kind == "beside_length"}
    assert any("20 c" in text and "left" in text for text in texts), texts


def test_numbers_in_words() -> None:
    assert [spelled(n) for n in (1, 12, 20, 34)] == ["one", "twelve", "twenty", "thirty-four"]
