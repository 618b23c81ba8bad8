"""The hand-written corpus: every line is read, and what varies in it keeps its meaning."""

import re

import numpy as np
import pytest

from w2c.errors import ConfigError
from w2c.messages import Box
from w2c_dialogue.corpus import written, written_lines
from w2c_dialogue.corpus.draw import Draw, is_held_out
from w2c_dialogue.corpus.measures import NUMBER_WORDS
from w2c_dialogue.corpus.moves import read_move
from w2c_dialogue.corpus.places import read_place
from w2c_dialogue.expressions import correction_symbols, evaluate, object_symbols
from w2c_dialogue.prompts.base import CorrectionScene, Move, SceneObject
from w2c_dialogue.prompts.spans import naming_spans

CUP = Box(left=600.0, top=300.0, right=700.0, bottom=400.0, score=1.0)
BOOK = Box(left=900.0, top=310.0, right=1000.0, bottom=350.0, score=1.0)


def draw(seed: int = 0) -> Draw:
    return Draw(np.random.default_rng(seed), held_out=False)


def place(note: str) -> tuple[float, float]:
    read = read_place(note)
    x, y = read.by_scene[0] if read.by_scene else (read.x, read.y)
    symbols = object_symbols([CUP, BOOK, CUP], 10.0)
    return evaluate(x, symbols), evaluate(y, symbols)


def moved(note: str) -> tuple[float, float]:
    scene = CorrectionScene(
        target=(500.0, 200.0),
        start=(400.0, 100.0),
        moves=(Move(100.0, 60.0), Move(0.0, 40.0)),
        instructions=("", ""),
        objects=(SceneObject("cup", CUP), SceneObject("book", BOOK)),
        pixels_per_cm=10.0,
    )
    point, _ = read_move(note)
    x, y = point.by_scene[0] if point.by_scene else (point.x, point.y)
    symbols = correction_symbols(scene)
    return evaluate(x, symbols), evaluate(y, symbols)


@pytest.mark.parametrize("kind", ["instructions", "corrections", "confirmations", "dialogues"])
def test_every_written_line_is_read(kind: written_lines.Kind) -> None:
    lines = written_lines.lines(kind)

    assert kind == "dialogues" or len(lines) > 5
    assert len({(line.meaning, line.text) for line in lines}) == len(lines)


def test_the_things_of_written_lines_may_be_answered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(written, "KEPT_SHARE", 1.0)
    source = draw()
    for line in (*written_lines.lines("instructions"), *written_lines.lines("corrections")):
        if not (line.meaning and "[" in line.text):
            continue  # of a turn of a dialogue only its module is asked
        make = written.instruction_of if line.kind == "instructions" else written.correction_of
        utterance, spans = make(line, source).draft.finish()
        allowed = naming_spans(utterance)
        for span in spans:
            assert span in allowed, f"{utterance.phrase(span)} in: {line.text}"


@pytest.mark.parametrize(
    ("note", "point"),
    [
        ("left(A)", (580, 350)),
        ("left(A,close)", (590, 350)),
        ("right(A, 3cm)", (730, 350)),
        ("front(A,far)", (650, 550)),
        ("edge(A,topleft)", (615, 315)),
        ("between(A,B)", (800, 340)),
        ("nearer(A,B)", (725, 345)),
        ("along(A,B,0.5)", (800, 340)),
        ("diagonal(A,left,behind)", (580, 280)),
        ("cross(left(A),front(B))", (580, 358)),
        ("level(right(A),B)", (720, 330)),
        ("middle(A,B)", (800, 340)),
        ("left(A,1hand)", (510, 350)),
        ("right(A,2finger)", (740, 350)),
        ("front(A,1thumb)", (650, 425)),
        ("behind(A,0.5foot)", (650, 150)),
    ],
)
def test_places_are_where_they_say(note: str, point: tuple[float, float]) -> None:
    assert place(note) == pytest.approx(point)


@pytest.mark.parametrize(
    ("note", "point"),
    [
        ("left bit", (480, 200)),
        ("right 3cm + up lot", (530, 100)),
        ("down 2steps", (500, 280)),
        ("again 1", (500, 240)),
        ("again -0.5", (500, 180)),
        ("undo 1", (500, 160)),
        ("undo 2", (400, 100)),
        ("start", (400, 100)),
        ("turn left 0.5", (480, 200)),
        ("closer A 0.5", (575, 275)),
        ("away A 1", (350, 50)),
        ("onto B", (950, 330)),
        ("place left(A)", (580, 350)),
        ("align_u A", (650, 200)),
        ("align_v A", (500, 350)),
        ("align_v A top", (500, 300)),
        ("align_v A bottom", (500, 400)),
        ("align_u A left", (600, 200)),
        ("left 1hand + up 2finger", (410, 160)),
        ("right 1arm", (1100, 200)),
        ("size right 0.5 A", (550, 200)),
        ("pixel 300 20", (300, 20)),
        ("stay", (500, 200)),
    ],
)
def test_corrections_go_where_they_say(note: str, point: tuple[float, float]) -> None:
    assert moved(note) == pytest.approx(point)


def test_left_and_right_are_exchanged_in_words_and_meaning_together() -> None:
    (line,) = written_lines.read_line(
        "instructions",
        "edge(A,topleft) right_hand contact | Right hand, far left of the [bright box]",
    )
    seen = {written.vary(line, draw(seed)) for seed in range(20)}

    assert seen == {
        ("edge(A,topleft) right_hand contact", "Right hand, far left of the [bright box]"),
        ("edge(A,topright) left_hand contact", "Left hand, far right of the [bright box]"),
    }


@pytest.mark.parametrize(
    "text",
    [
        "! left_hand | x",
        "absolute right_hand contact | put it right next to the [cup], right hand",
        "absolute right_hand contact | all right, right hand on the [cup]",
    ],
)
def test_a_right_that_is_no_side_stays(text: str) -> None:
    if text.startswith("!"):
        text = "! absolute right_hand contact | that's right, the [cup], right hand"
    (line,) = written_lines.read_line("instructions", text)

    assert not line.mirrors


def test_numbers_change_in_words_and_meaning_together() -> None:
    (line,) = written_lines.read_line(
        "corrections", "left {3}cm + up {two}cm | {3} cm left, {two} cm up"
    )
    varied = [written.correction_of(line, draw(seed)) for seed in range(30)]
    numbers = {re.split(r"[-+*]", made.x)[1] for made in varied}

    assert len(numbers) > 5
    for made in varied:
        assert made.draft.words[0] == re.split(r"[-+*]", made.x)[1]
        said = " ".join(made.draft.words).split(", ")[1].removesuffix(" cm up")
        assert NUMBER_WORDS[said] == re.split(r"[-+*]", made.y)[1]


def test_things_are_replaced_and_keep_their_letters() -> None:
    (line,) = written_lines.read_line(
        "instructions",
        "between(A,B) left_hand contact | left hand between the [fork] and the [jar]'s lid",
    )
    made = [written.instruction_of(line, draw(seed)) for seed in range(20)]

    assert len({" ".join(m.draft.words) for m in made}) > 10
    for instruction in made:
        utterance, spans = instruction.draft.finish()
        assert len(spans) == 2
        assert utterance.typed[spans[1][1] - 1].endswith("'s")
        assert instruction.scene.startswith("A ")
        assert instruction.x


def test_every_other_drawing_of_a_line_keeps_the_things_its_author_named() -> None:
    text = "lean on the [pew with the split armrest] by the [font]"
    (line,) = written_lines.read_line("instructions", f"between(A,B) left_hand contact | {text}")
    source = draw()
    drawn = [" ".join(written.instruction_of(line, source).draft.words) for _ in range(400)]

    assert 160 < drawn.count(text.replace("[", "").replace("]", "")) < 240


def test_a_thing_that_another_author_named_may_stand_in_a_line() -> None:
    (line,) = written_lines.read_line("corrections", "onto A | on the [vaulting horse]")
    source = draw()
    drawn = [" ".join(written.correction_of(line, source).draft.words[2:]) for _ in range(300)]
    of_training = {
        name
        for kind in ("instructions", "corrections", "confirmations", "dialogues")
        for other in written_lines.lines(kind)
        if not is_held_out(other)
        for name in re.findall(r"\[([^\]]+)\]", other.text)
    }

    lent = set(written.lent_names())
    assert 30 < len(lent & set(drawn)) < 120
    assert lent < of_training
    assert not any(name.startswith(("what ", "whatever ")) or "," in name for name in lent)


def test_the_turns_of_a_dialogue_are_lines_of_their_kinds() -> None:
    turns = list(written_lines.read_line("dialogues", "p c y | the [cup] / left / ok"))

    assert [(turn.kind, turn.text) for turn in turns] == [
        ("instructions", "the [cup]"),
        ("corrections", "left"),
        ("confirmations", "ok"),
    ]


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        ("instructions", "absolute right_hand contact lean on the [table]"),
        ("instructions", "absolute right_hand | lean on the [table]"),
        ("instructions", "absolute right_paw contact | lean on the [table]"),
        ("instructions", "absolute right_hand contact | lean on the table"),
        ("instructions", "left(B) right_hand contact | left of the [table] and the [cup]"),
        ("instructions", "under(A) right_hand contact | under the [table]"),
        ("instructions", "left(A,3miles) right_hand contact | left of the [table]"),
        ("corrections", "sideways | sideways"),
        ("corrections", "left + right | left and right"),
        ("corrections", "left {3}cm | a bit left"),
        ("corrections", "left {3}cm | {three or so} cm left"),
        ("corrections", "closer A 0.5 | closer to the cup"),
        ("corrections", "align_v A left | level with the left of the [cup]"),
        ("corrections", "undo 9 | all back"),
        ("confirmations", "maybe | yes"),
        ("dialogues", "p c | lean on the [table]"),
        ("dialogues", "p x | lean on the [table] / left"),
    ],
)
def test_a_line_that_means_nothing_is_refused(kind: written_lines.Kind, text: str) -> None:
    with pytest.raises(ConfigError):
        list(written_lines.read_line(kind, text))


def test_what_is_named_twice_keeps_its_name() -> None:
    text = "between the [flour bin] and the [scales], but nearer the scales, right hand"
    (line,) = written_lines.read_line("instructions", f"!nearer(B,A) right_hand contact | {text}")
    for seed in range(30):
        said = " ".join(written.instruction_of(line, draw(seed)).draft.words)
        assert said == text.replace("[", "").replace("]", "")


@pytest.mark.parametrize(
    ("flags", "mirrors", "tells"),
    [("", True, True), ("! ", False, True), ("? ", True, False), ("!? ", False, False)],
)
def test_flags_say_what_a_line_is_not_for(flags: str, *, mirrors: bool, tells: bool) -> None:
    (line,) = written_lines.read_line("corrections", f"{flags}place left(A) | left of the [cup]")

    assert (line.meaning, line.mirrors, line.tells) == ("place left(A)", mirrors, tells)


@pytest.mark.parametrize(
    ("kind", "text"),
    [("corrections", "? | left"), ("corrections", "| left"), ("dialogues", "? p c | on it / left")],
)
def test_flags_without_a_meaning_or_on_a_dialogue_are_refused(
    kind: written_lines.Kind, text: str
) -> None:
    with pytest.raises(ConfigError, match=r"meaning|flags"):
        list(written_lines.read_line(kind, text))


def test_lines_whose_words_alone_tell_no_module_choose_none() -> None:
    source = draw()
    silent = {line.text for line in written_lines.lines("corrections") if not line.tells}
    assert len(silent) > 500

    drawn = {" ".join(written.written_words(source, "corrections").words) for _ in range(3000)}
    plain = {re.sub(r"[\[\]{}<>]", "", text) for text in silent}
    moved = {" ".join(written.written_correction(source).draft.words) for _ in range(3000)}
    assert not drawn & plain
    assert moved & plain
