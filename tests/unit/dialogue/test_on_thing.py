"""A place on a part of a thing shows the thing, not what is seen past it."""

from typing import Any

import numpy as np
import pytest

from fakes.dialogue_world import KnownThings, ScriptedModel
from w2c.errors import ConfigError, DeadlineError
from w2c.messages import Array, Box, PhraseEvidence
from w2c_dialogue.expressions import ImagePoint
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.on_thing import onto_thing
from w2c_dialogue.prompts.base import SceneObject
from w2c_dialogue.prompts.sets import PROMPT_SETS
from w2c_dialogue.relative import predict
from w2c_dialogue.utterance import Mention, Span, parse

SIZE = (1280, 720)
CELL = 4
FRAME = Frame(0, *SIZE, b"picture")
BOARD = SceneObject("board", Box(left=400.0, top=200.0, right=800.0, bottom=600.0, score=0.9))
LEFT_END = ImagePoint(420.0, 400.0, clipped=False)
"""In the box of the board, but not on it: it lies askew"""


def slanted(height: int = 80) -> Array:
    """Return the heatmap of a board that goes from the upper left of its box to the lower right."""
    heatmap = np.zeros((SIZE[1] // CELL, SIZE[0] // CELL), np.uint8)
    rows, columns = np.indices(heatmap.shape)
    u, v = (columns + 0.5) * CELL, (rows + 0.5) * CELL
    on_it = (u >= 400) & (u < 800) & (np.abs((v - 200) - (u - 400)) < height)
    heatmap[on_it & (v >= 200) & (v < 600)] = 230
    return heatmap


class Eyes(KnownThings):
    """Sees the outline of a board, too."""

    def __init__(self, heatmap: Array | None) -> None:
        super().__init__(board=(400, 200, 800, 600))
        self.heatmap = heatmap

    def ground(self, frame: Frame, phrases: Any, want: Any) -> list[PhraseEvidence]:
        super().ground(frame, phrases, want)
        seen = PhraseEvidence(
            phrase="board",
            found=True,
            score=0.9,
            point=(600.0, 400.0),
            boxes=[BOARD.box],
            heatmap=self.heatmap,
        )
        return [seen for _ in phrases]


def test_a_place_in_the_corner_of_the_box_moves_onto_the_thing() -> None:
    moved = onto_thing(LEFT_END, [BOARD], Eyes(slanted()), FRAME)

    # 80 px above and below its diagonal the board ends; the place is a little inside.
    assert 40.0 < (moved.v - 200.0) - (moved.u - 400.0) < 80.0
    assert abs(moved.u - LEFT_END.u) < 80.0
    assert moved.v < LEFT_END.v


def test_a_place_on_the_thing_stays() -> None:
    point = ImagePoint(450.0, 250.0, clipped=False)
    assert onto_thing(point, [BOARD], Eyes(slanted()), FRAME) is point


def test_another_thing_that_is_lit_draws_no_place_to_it() -> None:
    heatmap = slanted(40)
    heatmap[:, : 400 // CELL] = 230
    moved = onto_thing(LEFT_END, [BOARD], Eyes(heatmap), FRAME)
    assert moved == onto_thing(LEFT_END, [BOARD], Eyes(slanted(40)), FRAME)


@pytest.mark.parametrize(
    ("objects", "point"),
    [
        pytest.param([BOARD], ImagePoint(390.0, 400.0, clipped=False), id="beside it"),
        pytest.param([], LEFT_END, id="on nothing"),
        pytest.param([BOARD, BOARD], LEFT_END, id="of two things"),
    ],
)
def test_of_every_other_place_nobody_asks(objects: list[SceneObject], point: ImagePoint) -> None:
    eyes = Eyes(slanted())
    assert onto_thing(point, objects, eyes, FRAME) is point
    assert eyes.asked == []


@pytest.mark.parametrize(
    "heatmap",
    [
        pytest.param(None, id="a model of boxes"),
        pytest.param(np.zeros((9, 16), np.uint8), id="a cold picture"),
    ],
)
def test_a_place_stays_where_no_outline_is_known(heatmap: Array | None) -> None:
    assert onto_thing(LEFT_END, [BOARD], Eyes(heatmap), FRAME) is LEFT_END


def test_a_place_stays_where_the_model_is_silent() -> None:
    eyes = Eyes(slanted())
    eyes.error = DeadlineError("no answer")
    assert onto_thing(LEFT_END, [BOARD], eyes, FRAME) is LEFT_END
    eyes.error = ConfigError("no failed call")
    with pytest.raises(ConfigError):
        onto_thing(LEFT_END, [BOARD], eyes, FRAME)


def test_a_relative_position_is_told_so() -> None:
    seen = PhraseEvidence(
        phrase="board", found=True, score=0.9, point=(600.0, 400.0), boxes=[BOARD.box]
    )
    prediction = predict(
        ScriptedModel(relative=[{"x": "a.left+0.05*a.width", "y": "a.v"}]),
        PROMPT_SETS["embedded"](),
        FRAME,
        utterance=parse("the left end of the board"),
        mentions=[Mention("board", Span(6, 6))],
        evidence=[seen],
        grounding=Eyes(slanted()),
        pixels_per_cm=8.0,
    )
    moved = onto_thing(LEFT_END, [BOARD], Eyes(slanted()), FRAME)
    assert (prediction.u, prediction.v) == (moved.u, moved.v)
    assert prediction.warnings == ()
