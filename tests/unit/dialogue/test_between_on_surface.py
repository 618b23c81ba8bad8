"""A place between two things stays between them, and one behind or before both stays there."""

import numpy as np
import pytest

from fakes.dialogue_world import KnownThings
from w2c.messages import Box, PhraseEvidence
from w2c_dialogue.expressions import ImagePoint
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.on_surface import onto_surface
from w2c_dialogue.prompts.base import SceneObject

FRAME = Frame(0, 1280, 720, b"picture")
CELL = 4
Edges = tuple[float, float, float, float]
SIDE_BY_SIDE: tuple[Edges, Edges] = ((400, 300, 500, 400), (800, 300, 900, 400))
ABOVE_ONE_ANOTHER: tuple[Edges, Edges] = ((300, 40, 400, 100), (300, 360, 400, 420))


class Crate(KnownThings):
    """Grounding that sees one green thing, and no surface."""

    def __init__(self, edges: Edges) -> None:
        super().__init__()
        left, top, right, bottom = (int(edge) // CELL for edge in edges)
        self._heatmap = np.zeros((720 // CELL, 1280 // CELL), np.uint8)
        self._heatmap[top:bottom, left:right] = 200

    def _evidence(self, phrase: str) -> PhraseEvidence:
        found = phrase == "green thing"
        return PhraseEvidence(
            phrase=phrase,
            found=found,
            score=0.8,
            point=None,
            boxes=[],
            heatmap=self._heatmap if found else None,
        )


def moved(u: float, v: float, things: tuple[Edges, Edges], crate: Edges) -> ImagePoint:
    boxes = (
        Box(left=left, top=top, right=right, bottom=bottom, score=0.9)
        for left, top, right, bottom in things
    )
    objects = [SceneObject("", box) for box in boxes]
    return onto_surface(ImagePoint(u, v, clipped=False), objects, Crate(crate), FRAME)


def test_side_by_side_it_moves_to_one_of_them() -> None:
    """The far sides of the crate are nearer than the things."""
    point = moved(650, 350, SIDE_BY_SIDE, (550, 280, 760, 410))

    assert 300 <= point.v < 400
    assert 500 <= point.u < 550 or 760 < point.u < 800


def test_above_one_another_it_moves_to_one_of_them() -> None:
    point = moved(350, 230, ABOVE_ONE_ANOTHER, (280, 140, 430, 320))

    assert 300 <= point.u < 400
    assert 100 <= point.v < 140 or 320 < point.v < 360


@pytest.mark.parametrize("v", [250, 280, 440])
def test_behind_or_before_both_it_stays(v: float) -> None:
    assert moved(650, v, SIDE_BY_SIDE, (20, 20, 60, 60)) == ImagePoint(650, v, clipped=False)
