"""Sentences that bind two words mean what they say: amounts and ways, things and sides, limbs."""

import re
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from w2c.messages import Box
from w2c_dialogue.corpus import (
    asides,
    instructions,
    relations,
)
from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.exact_moves import (
    along_axis,
    along_last,
    earlier_move,
    towards,
    two_lengths,
)
from w2c_dialogue.corpus.limbs import by_the_other
from w2c_dialogue.corpus.places import read_place
from w2c_dialogue.corpus.steering import Correction
from w2c_dialogue.expressions import correction_symbols, evaluate, object_symbols
from w2c_dialogue.prompts.base import CorrectionScene, Move, SceneObject
from w2c_dialogue.prompts.limb_words import named_limb
from w2c_dialogue.utterance import parse

SCENE = CorrectionScene((640, 360), (640, 360), (), (), (), 10.0)


def draw(seed: int = 0) -> Draw:
    return Draw(np.random.default_rng(seed), held_out=False)


@pytest.mark.parametrize("unit_again", [True, False])
def test_each_length_goes_in_the_direction_that_is_said_beside_it(*, unit_again: bool) -> None:
    source, seen = draw(2), 0
    way = r"(?:to the )?(left|right|up|down)"
    other = r"([0-9]+) (?:px|pixels?)" if unit_again else "([0-9]+)"
    pair = re.compile(
        rf"(?<![.,])\b([0-9]+) (?:px|pixels?) {way},? "
        rf"(?:and|then|plus|with|&|and just) {other} {way}\b"
    )
    for _ in range(20_000):
        made = two_lengths(source)
        found = pair.search(" ".join(made.draft.words))
        if found is None:
            continue
        along = {found[2]: float(found[1]), found[4]: float(found[3])}
        symbols = correction_symbols(SCENE)
        moved = evaluate(made.x, symbols) - 640, evaluate(made.y, symbols) - 360
        assert moved[0] == along.get("right", 0) - along.get("left", 0)
        assert moved[1] == along.get("down", 0) - along.get("up", 0)
        seen += 1
    assert seen


def test_a_length_is_measured_along_the_line_to_the_thing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The thing is at (100, 200) to (200, 300), the target 490 px right and 110 px below of it."""
    monkeypatch.setattr(asides, "ASIDE_SHARE", 0.0)  # "well away from the glass" is one
    source = draw(3)
    box = Box(left=100, top=200, right=200, bottom=300, score=1.0)
    scene = replace(SCENE, objects=(SceneObject("cup", box),))
    symbols = correction_symbols(scene)
    line = np.array([150.0 - 640.0, 250.0 - 360.0])
    signs = Counter[bool]()
    for _ in range(200):
        made = towards(source, "the {A}", {"A": "cup"})
        moved = np.array([evaluate(made.x, symbols) - 640, evaluate(made.y, symbols) - 360])
        cosine = moved @ line / np.linalg.norm(moved) / np.linalg.norm(line)
        away = re.search(r"\b(away|farther|further|back from|off|clear of|out from)\b", said(made))
        assert cosine == pytest.approx(-1.0 if away else 1.0)
        signs[bool(away)] += 1
    assert min(signs.values()) > 30


def test_a_length_back_is_measured_along_the_last_move() -> None:
    source = draw(4)
    symbols = correction_symbols(replace(SCENE, moves=(Move(0.0, 50.0), Move(-30.0, -40.0))))
    signs = Counter[bool]()
    for _ in range(300):
        made = along_last(source)
        moved = np.array([evaluate(made.x, symbols) - 640, evaluate(made.y, symbols) - 360])
        along = moved @ np.array([-0.6, -0.8])
        assert abs(along) == pytest.approx(np.linalg.norm(moved))
        back = re.search(r"\b(back|return|undo|past|too|over|less|off)", said(made))
        assert (along < 0) == bool(back), said(made)
        assert made.needs_past == 1
        signs[bool(back)] += 1
    assert min(signs.values()) > 50


def test_an_earlier_move_is_named_by_its_place() -> None:
    source = draw(5)
    moves = (Move(0.0, 50.0), Move(20.0, 0.0), Move(-30.0, -40.0))
    symbols = correction_symbols(replace(SCENE, moves=moves))
    seen = set()
    for _ in range(200):
        made = earlier_move(source)
        moved = evaluate(made.x, symbols) - 640, evaluate(made.y, symbols) - 360
        first = re.search(r"\bfirst\b", said(made)) is not None
        assert moved in (((0, 50), (0, -50)) if first else ((20, 0), (-20, 0)))
        seen.add(moved)
    assert len(seen) == 4


def test_minus_along_an_axis_is_to_the_left_or_up() -> None:
    source, symbols = draw(6), correction_symbols(SCENE)
    seen = Counter[tuple[float, float]]()
    for _ in range(300):
        made = along_axis(source)
        moved = evaluate(made.x, symbols) - 640, evaluate(made.y, symbols) - 360
        minus = re.search(r"minus|-|subtract|decrease|negative|less|off|reduce", said(made))
        vertical = re.search(r"\b([vy]|vertical)\b", said(made))
        assert (np.sign(sum(moved)) < 0) == bool(minus), said(made)
        assert bool(moved[1]) == bool(vertical), said(made)
        seen[np.sign(moved[0]), np.sign(moved[1])] += 1
    assert len(seen) == 4


@pytest.mark.parametrize(
    ("note", "scene", "point"),
    [
        ("side(A,B)", "A left of B", (220, 250)),
        ("otherside(A,B)", "A left of B", (80, 250)),
        ("side(A,B)", "A above B", (150, 320)),
        ("end(A,B)", "A right of B", (115, 250)),
        ("otherend(A,B)", "A below B", (150, 285)),
        ("behindboth(A,B)", "A left of B", (350, 180)),
        ("frontboth(A,B)", "A left of B", (350, 320)),
    ],
)
def test_a_place_by_two_things_follows_how_they_stand(
    note: str, scene: str, point: tuple[float, float]
) -> None:
    place = read_place(note)
    x, y = place.by_scene[place.scenes.index(scene)]
    boxes = [Box(left=at, top=200, right=at + 100, bottom=300, score=1.0) for at in (100, 500)]
    symbols = object_symbols(boxes, 10.0)

    assert (evaluate(x, symbols), evaluate(y, symbols)) == pytest.approx(point)


def test_drawn_places_by_two_things_mean_what_written_ones_mean() -> None:
    source, seen = draw(7), Counter[str]()
    for kind in ("side", "end") * 200:
        make = relations._side_by_another if kind == "side" else relations._end_by_another
        place = make(source)
        away = re.search(
            r"away|opposite|is not|not on|\bfar\b|other side|f[ua]rth|past|across", place.text
        )
        note = f"{'other' * bool(away)}{kind}"
        wanted = read_place(f"{note}(A,B)")
        assert (place.x, place.y) == wanted.by_scene[wanted.scenes.index(place.scene)], place
        seen[note] += 1
    assert min(seen[kind] for kind in ("side", "otherside", "end", "otherend")) > 20


def said(made: Correction) -> str:
    return " ".join(made.draft.words)


def test_a_limb_that_is_told_by_the_other_one_is_not_the_one_that_is_named() -> None:
    source, seen = draw(8), Counter[str]()
    for _ in range(300):
        text, limb = by_the_other(source, "lean on the {A}", feet=True)
        sides = set(re.findall(r"\b(left|right)\b", text))
        side, part = limb.split("_")
        assert part in text
        assert "{A}" in text
        assert sides == {"left", "right"} or side not in sides, text
        assert named_limb(parse(text.replace("{A}", "box"))) in (None, limb), text
        seen[limb] += 1
    assert set(seen) == {"left_hand", "right_hand", "left_foot", "right_foot"}


def test_what_is_not_meant_and_where_a_thing_stands_are_no_objects() -> None:
    source = draw(9)
    things = Counter[bool]()
    for _ in range(2000):
        made = instructions.instruction(source, "absolute", plain=True)
        utterance, spans = made.draft.finish()
        assert len(spans) == 1, utterance.text
        after = utterance.folded[spans[0][1] :]
        things["standing" in after or "lying" in after or "instead" in after] += 1
    assert things[True] > 20
