"""A place beside a thing is on the surface that carries it, and on nothing else."""

from typing import Any

import numpy as np
import pytest

from fakes.dialogue_world import KnownThings, ScriptedModel
from w2c.errors import ConfigError, DeadlineError
from w2c.messages import Box, PhraseEvidence
from w2c_dialogue.expressions import ImagePoint
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.on_surface import MARGIN, REACH, SURFACE, THINGS, look_for_surface, onto_surface
from w2c_dialogue.prompts.base import SceneObject
from w2c_dialogue.prompts.sets import PROMPT_SETS
from w2c_dialogue.relative import TAKEN, predict
from w2c_dialogue.utterance import Mention, Span, parse

SIZE = (1280, 720)
CELL = 4
CUP = SceneObject("cup", Box(left=400.0, top=300.0, right=500.0, bottom=400.0, score=0.9))
PLATE = SceneObject("plate", Box(left=540.0, top=300.0, right=700.0, bottom=400.0, score=0.9))


def table(*taken: Box) -> PhraseEvidence:
    """Return a table over the lower part of the picture, from 200 px down, with things on it."""
    heatmap = np.zeros((SIZE[1] // CELL, SIZE[0] // CELL), np.uint8)
    heatmap[200 // CELL :] = 230
    for box in taken:
        rows = slice(int(box.top) // CELL, int(box.bottom) // CELL)
        heatmap[rows, int(box.left) // CELL : int(box.right) // CELL] = 20
    return PhraseEvidence(
        phrase=SURFACE, found=True, score=0.9, point=(1.0, 1.0), boxes=[], heatmap=heatmap
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
    """Sees a surface, too."""

    def __init__(self, surface: PhraseEvidence | None) -> None:
        super().__init__()
        self.surface = surface

    def ground(self, frame: Frame, phrases: Any, want: Any) -> list[PhraseEvidence]:
        found = super().ground(frame, phrases, want)
        return found if self.surface is None or list(phrases) != [SURFACE] else [self.surface]


FRAME = Frame(0, *SIZE, b"picture")


def moved_onto(
    point: ImagePoint, surface: PhraseEvidence | None, objects: list[SceneObject]
) -> ImagePoint:
    return onto_surface(point, objects, Eyes(surface), FRAME)


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


def test_the_table_goes_on_beyond_the_edge_of_the_picture() -> None:
    point = at(1279.0, 719.0)
    assert moved_onto(point, table(), [CUP]) is point


NOTHING_SEEN = PhraseEvidence(
    phrase=SURFACE, found=True, score=0.9, point=None, boxes=[], heatmap=np.zeros((9, 16), np.uint8)
)
BOXES_ONLY = PhraseEvidence(phrase=SURFACE, found=True, score=0.9, point=None, boxes=[])


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


class EyesOnTheFloor(KnownThings):
    """Sees no surface, but things by their colour."""

    def __init__(self, *seen: PhraseEvidence) -> None:
        super().__init__()
        self.seen = {one.phrase: one for one in seen}

    def ground(self, frame: Frame, phrases: Any, want: Any) -> list[PhraseEvidence]:
        found = super().ground(frame, phrases, want)
        return [self.seen.get(one.phrase, one) for one in found]


def test_on_a_floor_a_place_moves_to_where_nothing_stands() -> None:
    eyes = EyesOnTheFloor(standing("red thing", CUP.box), standing("blue thing", PLATE.box))

    moved = onto_surface(at(550.0, 367.0), [CUP], eyes, FRAME)

    assert CUP.box.right < moved.u < PLATE.box.left - 0.5 * MARGIN * SIZE[0]
    assert moved.v == pytest.approx(367.0, abs=CELL)
    assert eyes.asked == [(0, (SURFACE,), "heatmaps"), (0, THINGS, "heatmaps")]


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
    assert onto_surface(point, [CUP], EyesOnTheFloor(*seen), FRAME) is point


def test_where_a_table_is_seen_nobody_asks_for_things() -> None:
    eyes = Eyes(table(CUP.box))
    onto_surface(at(450.0, 190.0), [CUP], eyes, FRAME)
    assert [phrases for _, phrases, _ in eyes.asked] == [(SURFACE,)]


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_it_is_moved_so_far_and_no_farther(share: float) -> None:
    edge = 200.0 + (round(MARGIN * SIZE[0] / CELL) + 0.5) * CELL
    point = at(450.0, edge - share * REACH * 100.0)

    assert (moved_onto(point, table(), [CUP]) is point) == (share > 1.0)


def test_surfaces_are_asked_for_as_a_heatmap() -> None:
    eyes = Eyes(table(CUP.box, PLATE.box))
    assert look_for_surface(eyes, FRAME) is not None
    assert eyes.asked == [(0, (SURFACE,), "heatmaps")]


def test_where_none_is_seen_nothing_is_known() -> None:
    assert look_for_surface(KnownThings(), FRAME) is None


def test_a_model_that_does_not_answer_is_asked_once_and_the_place_stays() -> None:
    eyes = Eyes(table(CUP.box, PLATE.box))
    eyes.error = DeadlineError("no answer")
    point = at(450.0, 190.0)

    assert onto_surface(point, [CUP], eyes, FRAME) is point
    assert eyes.asked == [(0, (SURFACE,), "heatmaps")]


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
