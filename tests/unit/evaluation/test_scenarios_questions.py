"""What the scripted operator answers when it is asked, and how that is written down."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes.scenario_world import SCENARIO, THINGS, AskingProduct, FlatWitness, Thing
from w2c.bus.inprocess import InProcessHub
from w2c.messages import Box, Evidence, Sighting, Turn
from w2c_dialogue import which
from w2c_evaluation.scenarios.answering import (
    Question,
    Wish,
    choose_option,
    in_other_words,
    read_question,
)
from w2c_evaluation.scenarios.conversation import Conversation
from w2c_evaluation.scenarios.film import Film
from w2c_evaluation.scenarios.phrase_book import PhraseBook
from w2c_evaluation.scenarios.record import PromptRun
from w2c_evaluation.scenarios.scenario import Meaning, Place, Prompt
from w2c_evaluation.scenarios.sight import Circle
from w2c_evaluation.scenarios.speaker import Speaker, Yes
from w2c_evaluation.scenarios.truth_log import TruthLog
from w2c_evaluation.scenarios.wording import Saying


def box(u: float, v: float, score: float = 0.9, half: float = 40.0) -> Box:
    return Box(left=u - half, top=v - half, right=u + half, bottom=v + half, score=score)


def asked(reply: str, options: list[str], **boxes: list[Box]) -> Turn:
    seen = [Sighting(phrase=name, found=True, score=0.9, boxes=b) for name, b in boxes.items()]
    return Turn(
        stamp_ns=1,
        text="",
        module="question",
        reply=reply,
        ok=False,
        options=options,
        seconds=0.1,
        evidence=Evidence(prompts="embedded", sightings=seen),
    )


CELLS = st.tuples(st.integers(0, 9), st.integers(0, 5))


@given(st.lists(CELLS, min_size=2, max_size=5, unique_by=(lambda c: c[0], lambda c: c[1])))
def test_the_dialogue_takes_the_answer_for_the_thing_that_was_meant(
    cells: list[tuple[int, int]],
) -> None:
    things = tuple(box(60.0 + 120.0 * column, 60.0 + 120.0 * row) for column, row in cells)
    question = Question(which.names(things), things)
    for index, thing in enumerate(things):
        answer = choose_option(question, Wish((thing.left + 10.0, thing.top + 10.0), 20.0))
        assert answer is not None
        assert which.read_answer(answer.split(), "mug", things) == index


def test_of_things_above_each_other_the_wanted_one_is_named() -> None:
    pair = (box(300.0, 500.0), box(310.0, 200.0))
    question = Question(("upper", "lower"), pair)
    assert choose_option(question, Wish((300.0, 510.0), 20.0)) == "lower"
    assert choose_option(question, Wish((300.0, 210.0), 20.0)) == "upper"


def test_what_is_not_among_the_options_is_not_chosen() -> None:
    pair = (box(200.0, 300.0), box(600.0, 300.0))
    assert choose_option(Question(("left", "right"), pair), Wish((400.0, 300.0), 20.0)) is None
    assert choose_option(Question(("red", "blue"), pair), Wish((200.0, 300.0), 20.0)) is None
    assert choose_option(Question(("left", "right")), Wish((200.0, 300.0), 20.0)) is None
    six = tuple(box(100.0 + 150.0 * n, 300.0) for n in range(6))
    assert choose_option(Question(("left", "right"), six), Wish((400.0, 300.0), 20.0)) is None


def test_a_place_beside_a_thing_is_not_on_another_one() -> None:
    """The box of a table around everything holds the place; the cup is what it is beside."""
    table, cup = box(700.0, 400.0, half=300.0), box(330.0, 400.0)
    question = Question(("left", "right"), (table, cup))
    assert choose_option(question, Wish((420.0, 400.0), 100.0, beside=True)) == "left"
    assert choose_option(question, Wish((420.0, 400.0), 100.0)) == "right"


def test_a_question_is_about_the_things_that_fit_apart_from_each_other() -> None:
    mugs = [
        box(200.0, 300.0),
        box(400.0, 300.0, 0.89, half=5.0),  # a speck
        box(205.0, 300.0, 0.88),  # the first one again
        box(600.0, 300.0, 0.87),
        box(900.0, 300.0, 0.2),
    ]
    question = read_question(
        asked(
            "Which 'mug': left or right? I see 2 that fit.", ["left", "right"], plate=[], mug=mugs
        )
    )
    assert question == Question(("left", "right"), (mugs[0], mugs[3]))
    assert read_question(asked("Here?", [])) is None


def test_a_new_place_or_a_change_is_answered_with_the_truth() -> None:
    speaker = Speaker(np.random.default_rng(0))
    question = Question(("new place", "change"))
    wanted = Circle((0.0, 0.0), np.eye(2), 8.0)
    said = (SCENARIO.prompts[0], Saying("up", 0.0, -40.0), Yes("yes"))
    answers = [speaker.answer_question(question, one, wanted) for one in said]
    assert answers == ["new place", "change", None]
    assert speaker.corrections == 0


def test_a_place_far_beside_its_thing_is_found_by_who_knows_how_far() -> None:
    question = Question(("left", "right"), (box(200.0, 300.0), box(900.0, 300.0)))
    wanted = Circle((400.0, 300.0), np.eye(2), 8.0)  # 20 cm to the right of the left one
    prompt = SCENARIO.prompts[0]
    near, far = (Speaker(np.random.default_rng(0), beside_cm=cm) for cm in (0.0, 20.0))
    assert near.answer_question(question, prompt, wanted) is None
    assert far.answer_question(question, prompt, wanted) == "left"


@pytest.mark.parametrize(
    ("meaning", "text"),
    [
        (
            Meaning("right_hand", "contact", "absolute", {"cup": "cup"}),
            "put your right hand on the cup",
        ),
        (
            Meaning("left_hand", "reach", "absolute", {"cup": "c"}),
            "go with your left hand for the cup",
        ),
        (
            Meaning("right_hand", "contact", "relative", {"cup": "c"}, "right"),
            "put your right hand to the right of the cup",
        ),
        (Meaning("right_hand", "contact", "absolute", {"cup": "c", "box": "b"}), ""),
        (Meaning("right_hand", "contact", "relative", {"cup": "c"}), ""),
    ],
)
def test_an_instruction_is_said_in_other_words(meaning: Meaning, text: str) -> None:
    prompt = Prompt("the cup, the box", meaning, Place("", "cup"))
    said = in_other_words(prompt)
    assert (said.text if said else "") == text
    assert said is None or said.meaning == meaning


def test_an_instruction_is_repeated_once() -> None:
    speaker = Speaker(np.random.default_rng(0))
    assert speaker.repeat(SCENARIO.prompts[0]) is not None
    assert speaker.repeat(SCENARIO.prompts[0]) is None


def talk(directory: Path, among: tuple[Thing, ...]) -> tuple[list[str], PromptRun]:
    """Play the first prompt with a product that asks."""
    hub = InProcessHub()
    book = PhraseBook({thing.name: thing.phrases() for thing in THINGS}, SCENARIO.phrases())
    product = AskingProduct(hub, among=among)
    with product:
        bus = hub.connect("operator")
        with TruthLog(hub.connect("evaluation"), FlatWitness()) as log:
            talking = Conversation(bus, log, book, Film(directory), rng=np.random.default_rng(2))
            talking.play(SCENARIO)
        return product.heard, talking.played.prompts[0]


def test_questions_are_answered_and_are_no_corrections(tmp_path: Path) -> None:
    heard, run = talk(tmp_path, THINGS)
    assert run.motion is not None
    assert heard[:2] == [SCENARIO.prompts[0].text, "left"]
    assert heard[3] == "change"
    turns = [(turn.kind, turn.asks, turn.answers) for turn in run.turns]
    assert turns[:4] == [
        ("prompt", "answered", False),
        ("prompt", "", True),
        ("correction", "answered", False),
        ("correction", "", True),
    ]
    assert run.turns[1].true_boxes
    said = [turn for turn in run.turns if turn.kind == "correction" and not turn.answers]
    assert run.corrections == len(said)


def test_who_is_asked_about_other_things_says_it_in_other_words_once(tmp_path: Path) -> None:
    others = (Thing("shelf", (0.2, 0.3), (0.1, 0.1, 0.0)), THINGS[1])
    heard, run = talk(tmp_path, others)
    assert heard[:2] == [SCENARIO.prompts[0].text, "put your right hand on the book"]
    assert run.turns[0].asks == "open"
    assert run.motion is not None
