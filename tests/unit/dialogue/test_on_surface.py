"""A place beside a thing is on the surface that carries it, and on nothing else."""

from typing import Any

import numpy as np
import pytest

from fakes.dialogue_world import KnownThings, ScriptedModel
from w2c.errors import ConfigError, DeadlineError
from w2c.messages import Box, PhraseEvidence
from w2c_dialogue.expressions import ImagePoint
from w2c_dialogue.heat import MARGIN
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.on_surface import (
    GROUND,
    REACH,
    SMALLEST,
    SURFACES,
    THINGS,
    look_for_surface,
    onto_surface,
)
from w2c_dialogue.prompts.base import SceneObject
from w2c_dialogue.prompts.sets import PROMPT_SETS
from w2c_dialogue.relative import TAKEN, predict
from w2c_dialogue.utterance import Mention, Span, parse

SIZE = (1280, 720)
CELL = 4
CUP = SceneObject("cup", Box(left=400.0, top=300.0, right=500.0, bottom=400.0, score=0.9))
PLATE = SceneObject("plate", Box(left=540.0, top=300.0, right=700.0, bottom=400.0, score=0.9))


def table(*taken: Box, word: str = "surface", columns: slice = slice(None)) -> PhraseEvidence:
    """Return a table over the lower part of the picture, from 200 px down, with things on it."""
    heatmap = np.zeros((SIZE[1] // CELL, SIZE[0] // CELL), np.uint8)
    heatmap[200 // CELL :, columns] = 230
    for box in taken:
        rows = slice(int(box.top) // CELL, int(box.bottom) // CELL)
        heatmap[rows, int(box.left) // CELL : int(box.right) // CELL] = 20
    return PhraseEvidence(
        phrase=word, found=True, score=0.9, point=(1.0, 1.0), boxes=[], heatmap=heatmap
    )


def standing(phrase: str, box: Box, *, found: bool = True) -> PhraseEvidence:
    """Return a thing that stands on the floor."""
    heatmap = np.zeros((SIZE[1] // CELL, SIZE[0] // CELL), np.uint8)
    rows = slice(int(box.top) // CELL, int(box.bottom) // CELL)
    heatmap[rows, int(box.left) // CELL : int(box.right) // CELL] = 200
    return PhraseEvidence(
        phrase=phrase, found=found, score=0.8, point=(1.0, 1.0), boxes=[box], heatmap=heatmap
    )


def at(u: float, v: float) -> ImagePoint:
    return ImagePoint(u, v, clipped=False)


class Eyes(KnownThings):
    """Sees surfaces and colours, too."""

    def __init__(self, *seen: PhraseEvidence) -> None:
        super().__init__()
        self.seen = {one.phrase: one for one in seen}

    def ground(self, frame: Frame, phrases: Any, want: Any) -> list[PhraseEvidence]:
        found = super().ground(frame, phrases, want)
        return [self.seen.get(one.phrase, one) for one in found]


FRAME = Frame(0, *SIZE, b"picture")


def moved_onto(
    point: ImagePoint, surface: PhraseEvidence | None, objects: list[SceneObject]
) -> ImagePoint:
    eyes = Eyes() if surface is None else Eyes(surface)
    return onto_surface(point, objects, eyes, FRAME)


def test_a_free_place_stays() -> None:
    point = at(530.0, 367.0)
    assert moved_onto(point, table(CUP.box), [CUP]) is point


def test_a_place_on_the_next_thing_moves_to_where_the_table_is_free() -> None:
    moved = moved_onto(at(550.0, 367.0), table(CUP.box, PLATE.box), [CUP])

    assert CUP.box.right < moved.u < PLATE.box.left
    assert moved.u < PLATE.box.left - 0.5 * MARGIN * SIZE[0]
    assert moved.v == pytest.approx(367.0, abs=CELL)


def test_a_place_past_the_edge_moves_onto_the_table() -> None:
    moved = moved_onto(at(450.0, 190.0), table(), [CUP])

    assert 200.0 + 0.5 * MARGIN * SIZE[0] < moved.v < 230.0
    assert moved.u == pytest.approx(450.0, abs=CELL)


@pytest.mark.parametrize(
    ("start", "level"),
    [pytest.param(345.0, True, id="it fits there"), pytest.param(300.0, False, id="too far")],
)
def test_left_of_a_thing_is_level_with_it_where_that_is_near(start: float, level: bool) -> None:
    taken = Box(left=start, top=300.0, right=400.0, bottom=420.0, score=0.9)

    moved = moved_onto(at(385.0, 395.0), table(CUP.box, taken), [CUP])

    assert (moved.v < 400.0) == level
    assert (moved.u < start) == level


@pytest.mark.parametrize(
    ("start", "level"),
    [pytest.param(255.0, True, id="it fits there"), pytest.param(220.0, False, id="too far")],
)
def test_so_is_behind_it(start: float, level: bool) -> None:
    taken = Box(left=390.0, top=start, right=520.0, bottom=300.0, score=0.9)

    moved = moved_onto(at(495.0, 285.0), table(CUP.box, taken), [CUP])

    assert (moved.u < 500.0) == level
    assert (moved.v < start) == level


def test_the_table_goes_on_beyond_the_edge_of_the_picture() -> None:
    point = at(1279.0, 719.0)
    assert moved_onto(point, table(), [CUP]) is point


NOTHING_SEEN = PhraseEvidence(
    phrase="surface",
    found=True,
    score=0.9,
    point=None,
    boxes=[],
    heatmap=np.zeros((9, 16), np.uint8),
)
BOXES_ONLY = PhraseEvidence(phrase="surface", found=True, score=0.9, point=None, boxes=[])


@pytest.mark.parametrize(
    ("point", "surface", "objects"),
    [
        pytest.param(at(410.0, 350.0), table(CUP.box), [CUP], id="on the thing itself"),
        pytest.param(at(550.0, 350.0), table(PLATE.box), [CUP, PLATE], id="on the other one"),
        pytest.param(at(450.0, 120.0), table(), [CUP], id="too far off"),
        pytest.param(at(450.0, 190.0), None, [CUP], id="no surface"),
        pytest.param(at(450.0, 190.0), NOTHING_SEEN, [CUP], id="a cold picture"),
        pytest.param(at(450.0, 190.0), BOXES_ONLY, [CUP], id="a model of boxes"),
        pytest.param(at(450.0, 190.0), table(), [], id="beside nothing"),
    ],
)
def test_every_other_place_stays(
    point: ImagePoint, surface: PhraseEvidence | None, objects: list[SceneObject]
) -> None:
    assert moved_onto(point, surface, objects) is point


def test_for_a_place_on_a_thing_nobody_looks() -> None:
    eyes = Eyes(table(CUP.box))
    onto_surface(at(450.0, 350.0), [CUP], eyes, FRAME)
    assert eyes.asked == []


def test_on_a_floor_a_place_moves_to_where_nothing_stands() -> None:
    eyes = Eyes(standing("red thing", CUP.box), standing("blue thing", PLATE.box))

    moved = onto_surface(at(550.0, 367.0), [CUP], eyes, FRAME)

    assert CUP.box.right < moved.u < PLATE.box.left - 0.5 * MARGIN * SIZE[0]
    assert moved.v == pytest.approx(367.0, abs=CELL)
    assert eyes.asked == [(0, SURFACES, "heatmaps"), (0, THINGS, "heatmaps")]


@pytest.mark.parametrize(
    "seen",
    [
        pytest.param([], id="nothing"),
        pytest.param([standing("blue thing", PLATE.box, found=False)], id="nothing sure"),
        pytest.param([standing("red thing", CUP.box)], id="something else"),
        pytest.param(
            [standing("red thing", Box(left=0.0, top=0.0, right=1280.0, bottom=720.0, score=0.9))],
            id="all over the picture",
        ),
    ],
)
def test_on_a_floor_a_place_stays_where_nothing_is_known_to_stand(
    seen: list[PhraseEvidence],
) -> None:
    point = at(560.0, 367.0)
    assert onto_surface(point, [CUP], Eyes(*seen), FRAME) is point


def test_where_a_table_is_seen_nobody_asks_for_things() -> None:
    eyes = Eyes(table(CUP.box))
    onto_surface(at(450.0, 190.0), [CUP], eyes, FRAME)
    assert [phrases for _, phrases, _ in eyes.asked] == [SURFACES]


def test_a_surface_may_be_seen_under_any_of_its_names() -> None:
    left, right = table(word="shelf", columns=slice(0, 125)), table(columns=slice(125, None))
    point = at(499.0, 420.0)

    # Between the two there is no edge to stay away from.
    assert onto_surface(point, [CUP], Eyes(left, right), FRAME) is point


def test_what_is_seen_faintly_beside_a_surface_is_none() -> None:
    faint = table(word="counter", columns=slice(100, None))
    assert faint.heatmap is not None
    faint.heatmap[:] //= 3
    surface = look_for_surface(Eyes(table(columns=slice(0, 100)), faint), FRAME)

    assert surface is not None
    assert surface[:, :100].any()
    assert not surface[:, 100:].any()


@pytest.mark.parametrize("share", [0.9, 1.2])
def test_a_speck_is_no_surface(share: float) -> None:
    lower = (SIZE[1] - 200) / SIZE[1]
    columns = slice(0, round(share * SMALLEST * SIZE[0] / CELL / lower))
    speck = table(columns=columns)

    assert (look_for_surface(Eyes(speck), FRAME) is None) == (share < 1.0)


@pytest.mark.parametrize(
    ("point", "taken", "where"),
    [
        pytest.param(at(395.0, 350.0), (356.0, 220.0, 420.0, 500.0), (342.0, 350.0), id="left"),
        pytest.param(at(505.0, 350.0), (480.0, 220.0, 550.0, 500.0), (562.0, 350.0), id="right"),
        pytest.param(at(450.0, 295.0), (300.0, 256.0, 600.0, 320.0), (450.0, 242.0), id="behind"),
        pytest.param(at(450.0, 405.0), (300.0, 380.0, 600.0, 450.0), (450.0, 462.0), id="before"),
    ],
)
def test_a_place_stays_on_the_side_of_the_thing_that_was_said(
    point: ImagePoint, taken: tuple[float, float, float, float], where: tuple[float, float]
) -> None:
    left, top, right, bottom = taken
    box = Box(left=left, top=top, right=right, bottom=bottom, score=0.9)
    # The surface is seen on a part of the thing, too, and nearer.
    moved = moved_onto(point, table(box), [CUP])
    assert (moved.u, moved.v) == pytest.approx(where, abs=CELL)


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_colour_of_the_ground_is_no_thing(share: float) -> None:
    width = share * GROUND * SIZE[0]
    left = 700.0 - 0.5 * width
    brown = Box(left=left, top=0.0, right=left + width, bottom=720.0, score=0.9)
    point = at(left + 20.0, 360.0)
    moved = onto_surface(point, [CUP], Eyes(standing("brown thing", brown)), FRAME)

    assert (moved is point) == (share > 1.0)


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_it_is_moved_so_far_and_no_farther(share: float) -> None:
    edge = 200.0 + (round(MARGIN * SIZE[0] / CELL) + 0.5) * CELL
    point = at(450.0, edge - share * REACH * 100.0)

    assert (moved_onto(point, table(), [CUP]) is point) == (share > 1.0)


def test_surfaces_are_asked_for_as_a_heatmap() -> None:
    eyes = Eyes(table(CUP.box, PLATE.box))
    assert look_for_surface(eyes, FRAME) is not None
    assert eyes.asked == [(0, SURFACES, "heatmaps")]


def test_where_none_is_seen_nothing_is_known() -> None:
    assert look_for_surface(KnownThings(), FRAME) is None


def test_a_model_that_does_not_answer_is_asked_once_and_the_place_stays() -> None:
    eyes = Eyes(table(CUP.box, PLATE.box))
    eyes.error = DeadlineError("no answer")
    point = at(450.0, 190.0)

    assert onto_surface(point, [CUP], eyes, FRAME) is point
    assert eyes.asked == [(0, SURFACES, "heatmaps")]


def test_an_error_that_is_no_failed_call_is_not_hidden() -> None:
    eyes = Eyes(table(CUP.box, PLATE.box))
    eyes.error = ConfigError("no failed call")
    with pytest.raises(ConfigError):
        onto_surface(at(450.0, 190.0), [CUP], eyes, FRAME)


@pytest.mark.parametrize(("away", "taken"), [("30", False), ("60", True)])
def test_who_spoke_is_told_that_a_place_was_taken(away: str, taken: bool) -> None:
    model = ScriptedModel(relative=[{"x": f"a.right+{away}", "y": "a.v"}])
    cup = PhraseEvidence(phrase="cup", found=True, score=0.9, point=(450.0, 350.0), boxes=[CUP.box])

    prediction = predict(
        model,
        PROMPT_SETS["embedded"](),
        FRAME,
        utterance=parse("right of the cup"),
        mentions=[Mention("cup", Span(4, 4))],
        evidence=[cup],
        grounding=Eyes(table(CUP.box, PLATE.box)),
        pixels_per_cm=8.0,
    )

    assert (TAKEN in prediction.warnings) == taken
    assert CUP.box.right < prediction.u < PLATE.box.left
