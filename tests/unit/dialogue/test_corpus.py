"""The corpus teaches what the run time asks and reads; its directions are those of the picture."""

import json
import re
from functools import cache

import jsonschema
import numpy as np
import pytest

from w2c.messages import Box
from w2c_dialogue.answers import AnalysisAnswer, EffectorAnswer, ObjectsAnswer, PointAnswer, read
from w2c_dialogue.corpus import correction_words, corrections, locations, relations, things
from w2c_dialogue.corpus.draw import Draw, is_held_out
from w2c_dialogue.corpus.generate import Example, examples
from w2c_dialogue.corpus.more_things import sounds_like_a_word
from w2c_dialogue.corpus.phrases import phrase
from w2c_dialogue.expressions import correction_symbols, evaluate_point, object_symbols
from w2c_dialogue.prompts.base import MODULES, CorrectionScene, Move, Question, SceneObject
from w2c_dialogue.prompts.embedded import EmbeddedPrompts
from w2c_dialogue.utterance import Utterance, parse

PROMPTS = EmbeddedPrompts()
BOXES = [
    Box(left=600, top=300, right=700, bottom=380, score=1.0),
    Box(left=800, top=310, right=860, bottom=370, score=1.0),
    Box(left=300, top=500, right=420, bottom=560, score=1.0),
]
SIZE = (1280, 720)
SCENE = CorrectionScene(
    (640, 360),
    (600, 330),
    (Move(5, 5), Move(-10, 5), Move(30, 0), Move(0, 20)),
    ("",) * 4,
    (),
    10.0,
)


@cache
def sample(*, held_out: bool = False) -> list[Example]:
    return list(examples(np.random.default_rng(7), 1500, held_out=held_out))


def of_task(task: str) -> list[tuple[str, str]]:
    """User content and answer of the training and held-out examples of a task."""
    every = [*sample(), *sample(held_out=True)]
    return [(e.messages[1]["content"], e.answer) for e in every if e.task == task]


def unnumbered(content: str) -> Utterance:
    words = enumerate(content.split(), 1)
    return parse(" ".join(word.removesuffix(str(number)).rstrip(".") for number, word in words))


def check_answer(question: Question, content: str, answer: str) -> object:
    """The question is asked in the same words at run time, and its schema allows the answer."""
    assert question.messages[1].content == content
    assert question.schema is not None
    value = json.loads(answer)
    jsonschema.validate(value, question.schema)
    assert list(value) == list(question.schema["properties"])
    assert answer == json.dumps(value, separators=(",", ":"), ensure_ascii=False)
    return value


def test_all_tasks_are_there() -> None:
    tasks = {e.task for e in sample()}
    assert tasks == {"select", "analyze", "objects", "relative", "correct", "effector"}
    assert all(e.messages[0] == {"role": "system", "content": e.task} for e in sample())


def test_select_answers_are_options_and_balanced() -> None:
    rows = of_task("select")
    for content, answer in rows:
        assert PROMPTS.select(parse(content)).messages[1].content == content
        assert answer in MODULES
    for module in MODULES:
        assert sum(answer == module for _, answer in rows) > 0.25 * len(rows)


def test_analyses_name_words_of_the_utterance() -> None:
    for content, answer in of_task("analyze"):
        utterance = unnumbered(content)
        value = read(check_answer(PROMPTS.analyze(utterance), content, answer), AnalysisAnswer)
        last = 0
        for entry in value.objects:
            mention = PROMPTS.read_mention(entry, utterance)
            assert mention.span is not None
            assert mention.phrase
            assert mention.span[0] > last, "objects come in order of mention"
            last = mention.span[1]


def test_objects_of_corrections_name_words_of_the_utterance() -> None:
    for content, answer in of_task("objects"):
        utterance = unnumbered(content)
        value = read(check_answer(PROMPTS.objects(utterance), content, answer), ObjectsAnswer)
        for entry in value.objects:
            assert PROMPTS.read_mention(entry, utterance).phrase


def test_effectors_are_read() -> None:
    for content, answer in of_task("effector"):
        question = PROMPTS.effector(parse(content))
        read(check_answer(question, content, answer), EffectorAnswer)


@pytest.mark.parametrize("task", ["relative", "correct"])
def test_expressions_give_points_with_the_symbols_of_their_scene(task: str) -> None:
    for content, answer in of_task(task):
        facts, text = content.split("\n")
        letters = re.findall(r"\b[ABC]\b", text)
        boxes = BOXES[: len(set(letters))]
        symbols = object_symbols(boxes, 10.0)
        if task == "correct":
            scene = CorrectionScene(
                **{**vars(SCENE), "objects": tuple(SceneObject("", b) for b in boxes)}
            )
            symbols = correction_symbols(scene)
        question = PROMPTS.relative(parse("x"), [], [], 10.0)
        assert question.schema is not None
        value = read(json.loads(answer), PointAnswer)
        jsonschema.validate({"x": value.x, "y": value.y}, question.schema)
        point = evaluate_point(value.x, value.y, symbols, SIZE)
        assert 0 < point.u < SIZE[0]
        assert 0 < point.v < SIZE[1]
        assert facts


def test_a_foot_only_stands() -> None:
    for content, answer in of_task("effector"):
        value = json.loads(answer)
        assert not (value["effector"].endswith("foot") and value["task"] == "reach"), content


def test_what_tells_one_from_another_belongs_to_its_name_and_where_it_stands_does_not() -> None:
    draw = Draw(np.random.default_rng(0), held_out=False)
    inside = [" ".join(phrase(draw).split()) for _ in range(3000)]
    assert any(text.endswith(" on the left") for text in inside)
    assert not any(text.endswith(things.PLACES) for text in inside)


def test_names_are_rarely_heard_twice() -> None:
    draw = Draw(np.random.default_rng(0), held_out=False)
    assert len({phrase(draw) for _ in range(1000)}) > 900
    assert len({sounds_like_a_word(draw) for _ in range(1000)}) > 900


@pytest.mark.parametrize(
    ("side", "du", "dv"), [("left", -1, 0), ("right", 1, 0), ("behind", 0, -1), ("front", 0, 1)]
)
def test_beside_is_outside_the_box_on_the_side_that_is_said(side: str, du: int, dv: int) -> None:
    box = BOXES[0]
    phrases, _, _ = locations.SIDES[side]
    draw, found = Draw(np.random.default_rng(3), held_out=False), 0
    while found < 100:
        location = relations.relative(draw)
        if not any(location.text == f"{phrase} {{A}}" for phrase in phrases):
            continue
        found += 1
        point = evaluate_point(location.x, location.y, object_symbols([box], 10.0), SIZE)
        assert np.sign(point.u - 650) == du
        assert np.sign(point.v - 340) == dv
        assert not (box.left <= point.u <= box.right and box.top <= point.v <= box.bottom)


DIRECTIONS = {
    "left": (-1, 0),
    "leftwards": (-1, 0),
    "leftward": (-1, 0),
    "right": (1, 0),
    "rightwards": (1, 0),
    "rightward": (1, 0),
    "up": (0, -1),
    "upwards": (0, -1),
    "upward": (0, -1),
    "higher": (0, -1),
    "down": (0, 1),
    "downwards": (0, 1),
    "downward": (0, 1),
    "lower": (0, 1),
}
OTHER_WAYS = frozenset(
    [
        "top",
        "bottom",
        "front",
        "back",
        "closer",
        "nearer",
        "towards",
        "toward",
        "away",
        "further",
        "farther",
        "ahead",
        "deeper",
        "forward",
        "forwards",
        "backward",
        "backwards",
        "and",
        "then",
    ]
)


def test_corrections_move_in_the_direction_that_is_said() -> None:
    draw, checked = Draw(np.random.default_rng(5), held_out=False), 0
    for _ in range(1000):
        made = corrections.correction(draw)
        text = " ".join(made.draft.words).lower()
        words = re.sub(r"(left|right) hand", "hand", text).replace(",", "").split()
        said = [DIRECTIONS[word] for word in words if word in DIRECTIONS]
        if len(said) != 1 or OTHER_WAYS & set(words) or "-" in "".join(words):
            continue
        if re.search(r"last|start|moves|[abc]\.", made.x + made.y):
            continue
        if (made.x, made.y) == ("target.u", "target.v"):
            continue
        point = evaluate_point(made.x, made.y, correction_symbols(SCENE), (10**6, 10**6))
        if not point.clipped:
            assert (np.sign(point.u - 640), np.sign(point.v - 360)) == said[0], text
            checked += 1
    assert checked > 50


@pytest.mark.parametrize(("text", "size"), [("a bit", 20), ("a little", 20), ("a lot", 100)])
def test_sizes_of_steps(text: str, size: int) -> None:
    listed = (correction_words.STEP, *(entry for _, entry in correction_words.STEPS))
    sizes = {word: int(pixels) for pixels, entries in listed for word in entries}
    assert sizes[text] == size
    assert sizes[""] == 40


def test_between_lies_between_the_boxes_as_the_facts_say() -> None:
    for content, answer in of_task("relative"):
        facts, text = content.split("\n")
        if (
            facts == "A left of B"
            and re.search(r"between", text)
            and "third" not in text
            and "C" not in text
        ):
            value = json.loads(answer)
            if value["x"] == "(a.right+b.left)/2":
                point = evaluate_point(value["x"], value["y"], object_symbols(BOXES, 10.0), SIZE)
                assert BOXES[0].right < point.u < BOXES[1].left
                return
    pytest.fail("no example of between")


def test_held_out_words_are_never_in_training() -> None:
    draw = Draw(np.random.default_rng(0), held_out=False)
    assert not any(is_held_out(draw.pick(things.THINGS)) for _ in range(5000))
    fresh = Draw(np.random.default_rng(0), held_out=True)
    assert any(is_held_out(fresh.pick(things.THINGS)) for _ in range(50))


def test_the_same_question_has_the_same_answer() -> None:
    answers: dict[tuple[str, str], set[str]] = {}
    for example in sample():
        key = example.task, example.messages[1]["content"]
        answers.setdefault(key, set()).add(example.answer)
    assert [key for key, have in answers.items() if len(have) > 1] == []
