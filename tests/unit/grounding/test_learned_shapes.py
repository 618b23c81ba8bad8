"""Vision models that learnt what colours and shapes are called, through the path of public ones."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from fakes.learned_dino import learned_grounding_dino
from fakes.shapes import PHRASES, SIDE, Shapes, draw_shapes, learned_clipseg
from w2c_grounding.evidence import peak_point
from w2c_grounding.family import Evidence, Family, ScoredBox
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import load

DINO = Path(__file__).parents[2] / "data" / "shapes_dino"
WIDTH, HEIGHT = 320, 180
"""Of the pictures that are asked about: models squash and scale them, and answer in their pixels"""


@pytest.fixture(scope="module")
def clipseg(tmp_path_factory: pytest.TempPathFactory) -> Family[Any]:
    directory = learned_clipseg(tmp_path_factory.mktemp("shapes"))
    return load(ModelConfig(model=str(directory), threads=1))[0]


def ask(family: Family[Any], shapes: Shapes) -> dict[str, Evidence]:
    large = cv2.resize(shapes.pixels, (WIDTH, HEIGHT), interpolation=cv2.INTER_LINEAR)
    context = family.prepare(np.asarray(large, np.uint8))
    return dict(zip(PHRASES, family.query(context, PHRASES), strict=True))


def test_clipseg_points_at_the_colour_and_shape_that_were_said(clipseg: Family[Any]) -> None:
    rng = np.random.default_rng(99)
    hits, refused = [], []
    for _ in range(20):
        shapes = draw_shapes(rng)
        for phrase, evidence in ask(clipseg, shapes).items():
            u, v = peak_point(evidence.heatmap)
            mask = shapes.masks.get(phrase)
            if mask is None:
                refused.append(float(evidence.heatmap.max()) < 0.5)
            else:
                hits.append(mask[int(v * SIDE / HEIGHT), int(u * SIDE / WIDTH)])
    assert np.mean(hits) >= 0.95
    assert np.mean(refused) >= 0.9


def test_grounding_dino_boxes_the_colour_and_shape_that_were_said() -> None:
    family, card = load(ModelConfig(model=str(DINO), threads=1))
    rng = np.random.default_rng(99)
    overlaps, refused = [], []
    for _ in range(12):
        shapes = draw_shapes(rng)
        evidence = family.query(family.prepare(shapes.pixels), PHRASES)
        for phrase, one in zip(PHRASES, evidence, strict=True):
            best = max(one.boxes or (), key=lambda box: box.score)
            if phrase in shapes.masks:
                assert best.score >= card.threshold
                overlaps.append(overlap(shapes.edges(phrase), best))
            else:
                refused.append(best.score < card.threshold)
    assert np.mean(np.array(overlaps) > 0.7) >= 0.95
    assert np.mean(refused) >= 0.95


def test_what_wrote_the_checkpoint_still_trains_and_writes_one(tmp_path: Path) -> None:
    directory = learned_grounding_dino(tmp_path, steps=2)

    family, _ = load(ModelConfig(model=str(directory), threads=1))
    picture = draw_shapes(np.random.default_rng(0)).pixels
    evidence = family.query(family.prepare(picture), PHRASES)
    assert all(np.isfinite(one.heatmap).all() for one in evidence)
    names = {path.name for path in directory.iterdir()}
    assert names == {path.name for path in DINO.iterdir()}
    sizes = [(one / "model.safetensors").stat().st_size for one in (directory, DINO)]
    assert sizes[0] == sizes[1]


def overlap(edges: tuple[int, int, int, int], box: ScoredBox) -> float:
    """Return intersection over union."""
    left, top, right, bottom = edges
    width = min(right, box.right) - max(left, box.left)
    height = min(bottom, box.bottom) - max(top, box.top)
    shared = max(0.0, width) * max(0.0, height)
    both = (right - left) * (bottom - top) + (box.right - box.left) * (box.bottom - box.top)
    return shared / (both - shared)
