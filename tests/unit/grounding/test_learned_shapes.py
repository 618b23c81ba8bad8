"""Vision models that learnt what colours and shapes are called, through the path of public ones."""

from typing import Any

import cv2
import numpy as np
import pytest

from fakes.shapes import PHRASES, SIDE, Shapes, draw_shapes, learned_clipseg
from w2c_grounding.evidence import peak_point
from w2c_grounding.family import Evidence, Family
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import load

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
