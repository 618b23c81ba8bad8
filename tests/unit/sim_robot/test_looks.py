"""What things are made of is said where it is seen, and tells nothing apart where it is not."""

import numpy as np
import pytest

from w2c_sim_robot.scenes.objects.catalogue import KINDS, make_object, shape_of
from w2c_sim_robot.scenes.objects.looks import SEEN, look_of, tells_apart
from w2c_sim_robot.scenes.objects.materials import printed
from w2c_sim_robot.scenes.wording import phrases_in, told_apart_by


@pytest.mark.parametrize(
    ("kind", "one", "other"),
    [
        ("toolbox", "metal", "plastic"),
        ("toolbox", "metal", "wood"),
        ("tray", "plastic", "wood"),
        ("shoe", "fabric", "leather"),
        ("soap_dispenser", "plastic", "glass"),
        ("box", "cardboard", "wood"),
        ("block", "stone", "wood"),
    ],
)
def test_grain_shine_and_what_shows_through_tell_materials_apart(
    kind: str, one: str, other: str
) -> None:
    assert tells_apart(kind, one, other)
    assert tells_apart(kind, other, one)


@pytest.mark.parametrize(
    ("kind", "one", "other"),
    [
        ("plate", "ceramic", "plastic"),
        ("bottle", "glass", "plastic"),
        ("flower_pot", "ceramic", "stone"),
        ("toolbox", "metal", "metal"),
        ("crate", "wood", "plastic"),
        ("box", "cardboard", "plastic"),
        ("bowl", "ceramic", "plastic"),
    ],
)
def test_what_looks_alike_tells_nothing(kind: str, one: str, other: str) -> None:
    assert not tells_apart(kind, one, other)
    assert not tells_apart(kind, other, one)


@pytest.mark.parametrize(
    "kind",
    [kind for kind, row in KINDS.items() if "metal" in row.materials and row.other_materials],
)
def test_what_may_be_of_metal_or_of_something_else_shines_as_metal(kind: str) -> None:
    assert look_of(kind, "metal").contrast > SEEN


def test_a_plastic_tray_has_no_grain_whichever_it_is() -> None:
    for variant in range(8):
        tray = make_object("tray", "brown", (0, 0, 0), variant=variant)
        for part in shape_of(tray).parts:
            texture = part.surface.texture
            assert texture is None or float(texture.std()) < SEEN * 255


def test_of_two_that_look_alike_each_may_be_called_what_the_other_is() -> None:
    plates = (
        make_object("plate", "red", (0, 0, 0), name="plate_0"),
        make_object("plate", "white", (1, 0, 0), name="plate_1", material="plastic"),
    )
    boxes = (
        make_object("toolbox", "red", (0, 0, 0), name="toolbox_0"),
        make_object("toolbox", "red", (1, 0, 0), name="toolbox_1", material="plastic"),
    )

    for plate in plates:
        assert {"ceramic plate", "plastic plate"} <= set(phrases_in(plate, plates))
    assert "plastic plate" not in phrases_in(plates[0], (plates[0], *boxes))
    for box, material, other in zip(boxes, ("metal", "plastic"), ("plastic", "metal"), strict=True):
        said = set(phrases_in(box, boxes))
        assert f"{material} toolbox" in said
        assert f"{other} toolbox" not in said


@pytest.mark.parametrize(("colour", "told_by"), [("red", "material"), ("black", "")])
def test_on_black_no_material_is_seen(colour: str, told_by: str) -> None:
    boxes = (
        make_object("toolbox", colour, (0, 0, 0), name="toolbox_0"),
        make_object("toolbox", colour, (1, 0, 0), name="toolbox_1", material="plastic"),
    )

    assert told_apart_by(*boxes) == told_by
    for box, other in zip(boxes, reversed(boxes), strict=True):
        alike = f"{other.material} toolbox" in phrases_in(box, boxes)
        assert alike == (told_by == "")


def test_a_cover_of_leather_keeps_its_print_and_shows_the_leather() -> None:
    paper, leather = (
        next(
            part.surface.texture
            for part in shape_of(make_object("book", "red", (0, 0, 0), material=material)).parts
            if part.name == "cover"
        )
        for material in ("paper", "leather")
    )
    assert paper is not None
    assert leather is not None
    ink = paper < 0.7 * paper.max()

    assert (leather <= paper).all()
    assert leather[ink].mean() < 0.7 * leather[~ink].mean()
    assert leather[~ink].std() > 2.0 * paper[~ink].std()


def test_white_ground_leaves_a_print_as_it_is() -> None:
    rng = np.random.default_rng(2)
    ink = rng.integers(0, 256, (24, 16, 3), dtype=np.uint8)

    assert np.array_equal(printed(ink, np.full((8, 8, 3), 255, dtype=np.uint8)), ink)
    assert not printed(ink, np.zeros((8, 8, 3), dtype=np.uint8)).any()
