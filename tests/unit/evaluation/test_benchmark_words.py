"""What things are called so that nothing else could be meant, and the sentences around it."""

from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np
import pytest

from w2c_evaluation.benchmark.figures import Figures, figures_of, missed
from w2c_evaluation.benchmark.naming import namings, told_apart
from w2c_evaluation.benchmark.plan import plan
from w2c_evaluation.benchmark.record import Origin, Record
from w2c_evaluation.benchmark.sentences import RELATIONS, instruct
from w2c_evaluation.benchmark.sight import Thing
from w2c_evaluation.benchmark.uses import ALSO_CALLED, USES
from w2c_sim_robot.scenes.objects.catalogue import KINDS


def thing(kind: str, names: Sequence[str], colour: str = "red", **changes: Any) -> Thing:
    values = {
        "id": 1, "name": f"{kind}_{colour}_{changes.get('material', '')}", "kind": kind,
        "colour": colour, "material": "", "names": names, "phrases": names, "own_phrases": [],
        "held_out": False, "held_out_kind": False, "held_out_material": False,
        "box": (0, 0, 9, 9), "visible_pixels": 81, "position": (0, 0, 0),
        "orientation": (0, 0, 0, 1), "size": (0.1, 0.1, 0.1), "movable": True,
        "support": "carries",
    }  # fmt: skip
    return msgspec.convert(values | changes, Thing)


MUG = thing("mug", ("cup", "mug"), "red", material="ceramic")
GLASS = thing("glass", ("glass", "tumbler"), "blue")
BOOK = thing("book", ("book", "hardcover"), "black")


def texts(one: Thing, *others: Thing) -> dict[str, str]:
    return {naming.text: naming.how for naming in namings(one, (one, *others))}


def test_a_thing_alone_may_be_called_anything_that_fits() -> None:
    assert texts(MUG, BOOK) == {
        "cup": "plain",
        "red cup": "plain",
        "ceramic cup": "plain",
        "mug": "synonym",
        "red mug": "synonym",
        "ceramic mug": "synonym",
        "red thing": "colour",
        "thing you drink coffee from": "use",
        "thing for hot drinks": "use",
    }


def test_another_of_its_kind_needs_an_attribute() -> None:
    other = thing("mug", ("cup", "mug"), "green", material="ceramic")
    found = namings(MUG, (MUG, other))

    assert "cup" not in {naming.text for naming in found}
    assert {n.attribute for n in found} == {"colour"}
    assert told_apart(MUG, other)


def test_colours_that_people_confuse_tell_nothing_apart() -> None:
    other = thing("mug", ("cup", "mug"), "orange", material="ceramic")

    assert texts(MUG, other) == {}
    assert not told_apart(MUG, other)


def test_a_material_tells_apart_what_has_one_colour() -> None:
    other = thing("mug", ("cup", "mug"), "red", material="metal")

    assert texts(MUG, thing("mug", ("cup", "mug"), "red", material="glass")) == {}
    assert texts(MUG, other) == {"ceramic cup": "plain", "ceramic mug": "synonym",
                                 "ceramic thing": "material"}  # fmt: skip


def test_a_material_that_does_not_show_tells_nothing_apart() -> None:
    other = thing(
        "mug", ("cup", "mug"), "red", material="metal",
        phrases=("cup", "mug", "metal cup", "ceramic cup"),
    )  # fmt: skip

    assert texts(MUG, other) == {}
    assert not told_apart(MUG, other)


def test_the_head_of_a_name_decides_what_else_could_be_meant() -> None:
    cereal = thing("cereal_box", ("cereal box", "packet"), "blue")
    nails = thing("nail_box", ("nail box", "box of nails"), "green")
    box = thing("box", ("box", "carton"), "red")

    assert "box" not in texts(box, cereal)
    assert texts(box, BOOK)["carton"] == "synonym"
    assert "carton" not in texts(box, cereal)  # some would say so of cereals
    assert "box of nails" not in texts(nails, box)
    assert texts(nails, BOOK)["box of nails"] == "synonym"


def test_a_use_is_said_only_where_one_thing_serves_it() -> None:
    assert "thing you drink coffee from" not in texts(MUG, GLASS)
    assert texts(MUG, BOOK)["thing you drink coffee from"] == "use"


def test_what_is_inside_has_not_the_colour_of_the_thing() -> None:
    box = thing("nail_box", ("nail box", "nails"), "red", material="cardboard")

    assert {"nails", "red nail box", "cardboard nail box"} <= set(texts(box, BOOK))
    assert not {"red nails", "cardboard nails"} & set(texts(box, BOOK))


def test_a_part_is_said_where_it_is_unique() -> None:
    phrase = "thing with the wooden handle"
    mallet = thing("mallet", ("mallet",), own_phrases=[phrase])

    assert texts(mallet, BOOK)[phrase] == "part"


def test_uses_speak_of_kinds_that_there_are() -> None:
    named = {kind for _, kinds in USES.values() for kind in kinds} | set(USES)
    named |= {kind for kinds in ALSO_CALLED.values() for kind in kinds}

    assert named <= set(KINDS)
    assert all(kind in kinds for kind, (_, kinds) in USES.items())


@pytest.mark.parametrize("relation", RELATIONS)
@pytest.mark.parametrize(("limb", "task"), [("hand", "contact"), ("hand", "reach"),
                                            ("foot", "contact")])  # fmt: skip
def test_a_sentence_names_the_things_and_the_limb(relation: str, limb: str, task: Any) -> None:
    rng = np.random.default_rng(3)
    words = ("red cup", "rag")[: 2 if relation == "between" else 1]
    for _ in range(20):
        said = instruct(relation, words, limb, task, 10, rng)

        assert all(f"the {word}" in said.text for word in words)
        assert not set("{}") & set(said.text)
        assert said.text.lower().count(said.end_effector.partition("_")[0]) >= 1
        assert said.end_effector.endswith(limb)
        assert said.verb in said.text.lower()
        assert "{" not in said.verb and len(said.verb.split()) <= 3
        assert "you to using" not in said.text and "you using" not in said.text


def test_slots_are_balanced_in_both_halves() -> None:
    slots = plan(78)
    for position in ("absolute", "relative"):
        half = [slot for slot in slots if slot.position == position]
        assert len(half) == 39
        assert sum(slot.look == "outdoor" for slot in half) in (12, 13, 14)
        assert sum(slot.limb == "foot" for slot in half) in (4, 5)
        assert sum(not slot.plain for slot in half) >= 24
        assert sum(slot.pair for slot in half) >= 15


def record(number: int, **changes: Any) -> Record:
    values = {
        "scene": 1, "look": "outdoor" if number % 2 else "indoor", "stage": "table",
        "relation": "on", "naming": "synonym", "attribute": "colour", "pair": True,
        "distractors": 5, "verb": f"verb {number}", "end_effector": "left_foot",
        "task": "contact", "held_out": False,
    }  # fmt: skip
    position: Any = ("absolute", "relative")[number % 2]
    origin = Origin(**(values | changes))
    return Record(id=f"{number}", prompt="x", position=position, origin=origin)


def figures(count: int = 8, shares: float = 0.05, **changes: Any) -> Figures:
    return figures_of([record(i, **changes) for i in range(count)], [shares] * count)


def test_a_benchmark_that_keeps_every_limit_misses_none() -> None:
    found = figures()

    assert missed(found) == []
    assert found.random == {"absolute": 0.05, "relative": 0.05, "overall": 0.05}


@pytest.mark.parametrize(
    ("kwargs", "part"),
    [
        ({"shares": 0.18}, "random points hit 0.180"),
        ({"naming": "plain"}, "avoid the usual name"),
        ({"pair": False}, "hold two of a kind"),
        ({"distractors": 3}, "3 distractors"),
        ({"look": "indoor"}, "look outdoors"),
        ({"end_effector": "left_hand", "count": 40}, "for a foot"),
        ({"verb": "put"}, "1 verbs"),
    ],
)
def test_a_benchmark_that_is_easy_says_why(kwargs: dict[str, Any], part: str) -> None:
    assert any(part in complaint for complaint in missed(figures(**kwargs)))
