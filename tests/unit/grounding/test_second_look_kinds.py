"""Things of one kind are told apart across pictures."""

import numpy as np
import numpy.typing as npt
import pytest

from w2c_grounding.second_look.network import SecondLookNetwork
from w2c_grounding.train.data import ObjectTruth, PictureTruth
from w2c_grounding.train.second_look import batches
from w2c_grounding.train.second_look.batches import SquareBatches
from w2c_grounding.train.second_look.kinds import Kinds
from w2c_grounding.train.second_look.squares import SIDE, Cut, Squares
from w2c_grounding.train.vocabulary import vocabulary_of

LOOKS_LIKE = {"black": ("leather",)}
"""On black nothing is seen"""


def thing(number: int, kind: str, colour: str, material: str) -> ObjectTruth:
    names = (kind,)
    phrases = (kind, f"{colour} {kind}", f"{material} {kind}", f"{colour} {material} {kind}")
    looks_like = LOOKS_LIKE.get(colour, ())
    return ObjectTruth(number, kind, colour, names, phrases, 400, material, looks_like=looks_like)


PICTURES = (
    (thing(1, "book", "red", "leather"), thing(2, "cup", "blue", "metal")),
    (thing(1, "book", "red", "paper"), thing(2, "bowl", "blue", "metal")),
    (thing(1, "book", "orange", "leather"), thing(2, "table", "brown", "wooden")),
    (thing(1, "bowl", "green", "ceramic"), thing(2, "table", "brown", "wooden")),
    (thing(1, "book", "black", "paper"), thing(2, "cup", "green", "plastic")),
)


def squares() -> Squares:
    """Each picture: its two things, then a place where nothing was."""
    truths = tuple(
        PictureTruth("", "", 100, 100, number, things) for number, things in enumerate(PICTURES)
    )
    cuts = []
    for things in PICTURES:
        cuts += [Cut(item, frozenset({item.id})) for item in things]
        cuts.append(Cut(None, frozenset()))
    pixels: npt.NDArray[np.uint8] = np.zeros((len(cuts), SIDE, SIDE, 3), np.uint8)
    ranges = tuple(range(3 * number, 3 * number + 3) for number in range(len(PICTURES)))
    return Squares(pixels, tuple(cuts), truths, ranges)


PAPER_BOOK, ORANGE_BOOK, BLACK_BOOK = 3, 6, 12


@pytest.mark.parametrize(
    ("phrase", "expected"),
    [
        # The black one, of paper, might be of leather: neither right nor wrong.
        ("the leather book", {PAPER_BOOK: False, ORANGE_BOOK: True}),
        ("the paper book", {PAPER_BOOK: True, ORANGE_BOOK: False, BLACK_BOOK: True}),
        ("book", {PAPER_BOOK: True, ORANGE_BOOK: True, BLACK_BOOK: True}),
        # Orange may be called red.
        ("red book", {PAPER_BOOK: True, BLACK_BOOK: False}),
        ("my leather thing", {PAPER_BOOK: False, ORANGE_BOOK: True}),
        # Says no more than the kind.
        ("thing to read", {}),
    ],
)
def test_a_phrase_is_asked_of_things_of_its_kind_in_other_pictures(
    phrase: str, expected: dict[int, bool]
) -> None:
    kinds = Kinds(squares())
    found = kinds.elsewhere(phrase, [PICTURES[0][0]], range(3, 15))
    assert dict(found) == expected


def test_what_is_asked_of_its_own_picture_only() -> None:
    kinds = Kinds(squares())
    assert kinds.elsewhere("violin", [], range(3, 15)) == []
    assert kinds.elsewhere("table", [PICTURES[2][1]], range(9, 15)) == [], "it is everywhere"


def test_a_group_of_pictures_holds_a_kind_that_is_no_furniture() -> None:
    kinds = Kinds(squares())
    rng = np.random.default_rng(0)
    drawn = [one for _ in range(20) for one in kinds.draw(3, 4, rng)]
    assert {kind for _, kind in drawn} == {"book", "cup", "bowl"}
    assert len(drawn) == 20 * (4 + 2 + 2), "each picture of a kind once"
    for picture, kind in drawn:
        assert kind in {item.kind for item in PICTURES[picture]}


def test_questions_tell_a_thing_by_material_more_often_than_by_colour() -> None:
    truth = squares().truths[0]
    found = Kinds(squares()).questions(truth, "book", 300, np.random.default_rng(0))
    assert {one.identities for one in found} == {(1,)}
    by_material = sum("leather" in one.phrase for one in found)
    assert 0.55 < by_material / len(found) < 0.9
    assert Kinds(squares()).questions(truth, "bowl", 5, np.random.default_rng(0)) == []


def test_a_step_asks_across_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batches, "BY_CHANCE", 2)
    monkeypatch.setattr(batches, "GROUPS", 1)
    monkeypatch.setattr(batches, "PRESENT", 2)
    monkeypatch.setattr(batches, "ABSENT", 1)
    data = squares()
    network = SecondLookNetwork(vocabulary_of(data.truths))
    across = 0
    for step in range(8):
        batch = SquareBatches(data, network, seed=3).make(step)
        assert len(set(batch.numbers.tolist())) == len(batch.numbers), "no picture twice"
        phrases = batch.pairs[:, 1]
        assert bool((phrases[1:] >= phrases[:-1]).all()), "as the loss needs them"
        for square, phrase in batch.pairs.tolist():
            own = {
                int(batch.numbers[other]) // 3
                for (other, asked), fits in zip(batch.pairs.tolist(), batch.fits, strict=True)
                if asked == phrase and fits
            }
            across += bool(own) and int(batch.numbers[square]) // 3 not in own
    assert across > 0
