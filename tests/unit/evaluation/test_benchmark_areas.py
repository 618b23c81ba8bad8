"""Accepted areas: measured by hand in pictures from straight above."""

import numpy as np
import pytest

from fakes.flat_world import HEIGHT, TABLE, WIDTH, Lying, picture_of, pixels_per_metre
from w2c_evaluation.benchmark import areas
from w2c_evaluation.benchmark.offers import area_of, offer, without_dust
from w2c_evaluation.benchmark.plan import Slot
from w2c_evaluation.benchmark.sight import Mask, Sight, Thing, footprint_distance, sight_of

SCALE = pixels_per_metre(TABLE)
BOOK = Lying("book", "red", 120, 90)
MUG = Lying("mug", "blue", 230, 90)


@pytest.fixture(scope="module")
def sight() -> Sight:
    return sight_of(picture_of([BOOK, MUG]))


def things(sight: Sight) -> tuple[Thing, Thing]:
    by_kind = {thing.kind: thing for thing in sight.things}
    return by_kind["book"], by_kind["mug"]


def extents(mask: Mask) -> tuple[int, int, int, int]:
    rows, columns = np.nonzero(mask)
    return columns.min(), rows.min(), columns.max() + 1, rows.max() + 1


def test_every_pixel_is_where_its_depth_puts_it(sight: Sight) -> None:
    """The middle of the picture is below the camera; up in the picture is ahead."""
    assert sight.world[90, 160].tolist() == pytest.approx([1.0, 0.0, TABLE], abs=0.005)
    assert sight.world[10, 160, 0] == pytest.approx(1.0 + 80 / SCALE, abs=0.005)
    assert sight.world[90, 20, 1] == pytest.approx(140 / SCALE, abs=0.005)


def test_unknown_depth_is_no_place() -> None:
    picture = picture_of([BOOK])
    picture.depth[5, 5] = 0.0

    seen = sight_of(picture)

    assert np.isnan(seen.world[5, 5]).all()
    assert not seen.free_surface(TABLE)[5, 5]


def test_on_a_thing_is_all_that_is_seen_of_it(sight: Sight) -> None:
    book, _ = things(sight)

    assert extents(areas.on(sight, book)) == book.edges


def sunk_on_the_left(lying: Lying, by: float) -> tuple[Sight, Thing]:
    """Return a picture of one thing whose part left of u = 110 lies lower [m], and the thing."""
    picture = picture_of([lying])
    rows, columns = np.nonzero(picture.identity == 2)
    left = columns < 110
    picture.depth[rows[left], columns[left]] += by
    seen = sight_of(picture)
    return seen, next(thing for thing in seen.things if thing.kind == lying.kind)


def test_the_top_leaves_out_what_is_low() -> None:
    seen, box = sunk_on_the_left(Lying("box", "red", 120, 90, (0.2, 0.2, 0.2)), by=0.15)

    assert extents(areas.on_top(seen, box))[0] == 110
    assert extents(areas.on(seen, box))[0] < 110


def test_the_top_of_a_tray_is_its_floor_too() -> None:
    seen, tray = sunk_on_the_left(Lying("tray", "red", 120, 90, (0.2, 0.2, 0.035)), by=0.03)

    assert extents(areas.on_top(seen, tray)) == tray.edges


@pytest.mark.parametrize("side", areas.SIDES)
def test_beside_a_thing_is_free_near_and_on_that_side(sight: Sight, side: str) -> None:
    book, _ = things(sight)
    mask = areas.beside(sight, book, side)
    left, top, right, bottom = book.edges
    u0, v0, u1, v1 = extents(mask)

    assert mask.any()
    assert set(sight.identity[mask]) == {1}
    assert {"left": u1 <= left, "right": u0 >= right, "behind": v1 <= top, "front": v0 >= bottom}[
        side
    ]
    away = {"left": left - u0, "right": u1 - right, "behind": top - v0, "front": v1 - bottom}[side]
    assert away == pytest.approx(min(areas.REACH_M * SCALE, away), abs=3)
    distance = footprint_distance(book, sight.world[mask])
    assert distance.min() >= 0.0 and distance.max() <= areas.REACH_M


def test_a_distance_that_was_said_is_kept(sight: Sight) -> None:
    book, _ = things(sight)
    mask = areas.measured(sight, book, "left", 0.15)
    u0, _, u1, _ = extents(mask)

    assert (book.edges[0] - u1) / SCALE == pytest.approx(0.15 - 0.07, abs=0.015)
    assert (book.edges[0] - u0) / SCALE == pytest.approx(0.15 + 0.07, abs=0.015)


def test_next_to_a_thing_is_all_around_it_and_not_on_it(sight: Sight) -> None:
    book, _ = things(sight)
    mask = areas.next_to(sight, book)
    left, top, right, bottom = book.edges
    u0, v0, u1, v1 = extents(mask)

    assert u0 < left and v0 < top and u1 > right and v1 > bottom
    assert not mask[top:bottom, left:right].any()


def test_between_two_things_is_the_gap(sight: Sight) -> None:
    book, mug = things(sight)
    mask = areas.between(sight, book, mug)

    assert extents(mask) == (book.edges[2], *book.edges[1:2], mug.edges[0], mug.edges[3])
    assert not areas.between(sight, book, book).any()


@pytest.mark.parametrize(("side", "place"), [("left", 0), ("front", 3)])
def test_an_end_of_a_thing_is_two_fifths_of_it(sight: Sight, side: str, place: int) -> None:
    book, _ = things(sight)
    found = extents(areas.end_of(sight, book, side))

    assert found[place] == book.edges[place]
    axis = 0 if side == "left" else 1
    whole = book.edges[axis + 2] - book.edges[axis]
    assert found[axis + 2] - found[axis] == pytest.approx(0.4 * whole, abs=1)


def test_what_others_hide_or_the_picture_cuts_is_known() -> None:
    picture = picture_of([BOOK, MUG])
    picture.truth["objects"][1]["box"][2] -= 14

    seen = sight_of(picture)
    book, mug = things(seen)

    assert seen.hidden(book) and not seen.hidden(mug)
    assert not seen.cut_off(book)
    assert sight_of(picture_of([Lying("book", "red", 6, 90)])).cut_off(
        things_of(sight_of(picture_of([Lying("book", "red", 6, 90)])), "book")
    )


def test_nothing_is_free_where_the_robot_or_another_thing_is(sight: Sight) -> None:
    picture = picture_of([BOOK, Lying("box", "green", 95, 90, (0.16, 0.05, 0.03))])
    picture.identity[:, 60:80] = 255

    seen = sight_of(picture)
    mask = areas.beside(seen, things_of(seen, "book"), "left")

    assert set(seen.identity[mask]) == {1}


def things_of(sight: Sight, kind: str) -> Thing:
    return next(thing for thing in sight.things if thing.kind == kind)


def test_a_sheet_of_paper_is_not_the_table_it_lies_on() -> None:
    paper = Lying("sponge", "green", 85, 90, (0.16, 0.10, 0.001))
    seen = sight_of(picture_of([BOOK, paper]))
    mask = areas.beside(seen, things_of(seen, "book"), "left")

    assert mask.any()
    assert set(seen.identity[mask]) == {1}


@pytest.mark.parametrize(("others", "offered"), [(3, False), (4, True)])
def test_a_picture_with_few_things_offers_nothing(others: int, offered: bool) -> None:
    colours = ("green", "blue", "black", "green")
    kinds = ("bottle", "box", "cloth", "plate")
    around = [Lying(kinds[i], colours[i], 60 + 60 * i, 140) for i in range(others)]
    slot = Slot(0, "absolute", "indoor", "hand", pair=False, plain=True)
    seen = sight_of(picture_of([BOOK, *around]))

    assert (offer(seen, slot, np.random.default_rng(0)) is not None) == offered


def test_every_relation_has_an_area(sight: Sight) -> None:
    book, mug = things(sight)
    relations = ("on", "on_top", "next", "between", "left", "end_right", "measured_left")

    for relation in relations:
        assert area_of(sight, relation, (book, mug), 10).any(), relation


def test_dust_is_no_area() -> None:
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[20:60, 20:60] = True
    mask[100:102, 100:102] = True

    assert extents(without_dust(mask)) == (20, 20, 60, 60)


def test_distance_is_from_the_edge_of_the_footprint() -> None:
    book = things(sight_of(picture_of([BOOK, MUG])))[0]
    x, y, z = book.position
    points = np.array([[x, y, z], [x + 0.18, y, z], [x + 0.11, y + 0.12, z]], np.float32)

    assert footprint_distance(book, points) == pytest.approx([0.0, 0.10, 0.05], abs=1e-3)
