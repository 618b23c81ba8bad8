"""OWLv2 through the public loading path, on a checkpoint with random weights."""

import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from transformers import Owlv2ForObjectDetection, Owlv2Processor

from w2c_grounding.family import Evidence
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.owlv2 import Owlv2

PHRASES = ["red cup", "the book", "green square"]
Picture = np.ndarray[tuple[int, ...], np.dtype[np.uint8]]


def picture(seed: int = 0, height: int = 90, width: int = 160) -> Picture:
    noise = np.random.default_rng(seed).integers(0, 255, (height // 10, width // 10, 3))
    return np.repeat(np.repeat(noise, 10, axis=0), 10, axis=1).astype(np.uint8)


@pytest.fixture(scope="module")
def owl(owlv2_checkpoint: Path) -> Owlv2:
    return Owlv2.load(ModelConfig(threads=1), str(owlv2_checkpoint), "a photo of a {}")


def rows(evidence: Evidence) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return the boxes (n, 5), best first."""
    assert evidence.boxes is not None
    return np.array(sorted(evidence.boxes, key=lambda box: -box.score))


@pytest.mark.parametrize(("height", "width"), [(90, 120), (120, 90)], ids=["wide", "high"])
def test_the_picture_tower_once_gives_what_the_whole_model_gives(
    owl: Owlv2, owlv2_checkpoint: Path, height: int, width: int
) -> None:
    """On pictures that are no squares too: their boxes are fractions of the padded square."""
    image = picture(0, height, width)
    processor = Owlv2Processor.from_pretrained(owlv2_checkpoint)
    model: Any = Owlv2ForObjectDetection.from_pretrained(owlv2_checkpoint, dtype=torch.float32)
    texts = ["a photo of a red cup", "a photo of a book", "a photo of a green square"]
    inputs = processor(text=[texts], images=image, truncation=True, return_tensors="pt")
    with torch.inference_mode():
        outputs = model.eval()(**inputs)
    scores = outputs.logits[0].sigmoid().numpy()  # (patches, phrases)
    centre, size = outputs.pred_boxes[0, :, :2].numpy(), outputs.pred_boxes[0, :, 2:].numpy()
    corners = np.concatenate([centre - size / 2, centre + size / 2], axis=1) * max(height, width)
    for index, evidence in enumerate(owl.query(owl.prepare(image), PHRASES)):
        # Not in order: some scores are nearly the same.
        expected = np.column_stack([corners, scores[:, index]])
        differences = np.abs(rows(evidence)[:, None, :] - expected[None, :, :]).max(axis=2)
        np.testing.assert_allclose(differences.min(axis=0), 0.0, atol=1e-2)
        np.testing.assert_allclose(differences.min(axis=1), 0.0, atol=1e-2)


def test_phrases_together_give_what_each_gives_alone(owl: Owlv2) -> None:
    context = owl.prepare(picture())
    for phrase, expected in zip(PHRASES, owl.query(context, PHRASES), strict=True):
        (alone,) = owl.query(context, [phrase])
        np.testing.assert_allclose(rows(alone), rows(expected), atol=1e-4)


def test_picture_and_phrase_both_matter(owl: Owlv2) -> None:
    first, other = owl.query(owl.prepare(picture(0)), ["book", "cup"])
    (elsewhere,) = owl.query(owl.prepare(picture(1)), ["book"])
    assert np.abs(rows(first)[:, 4] - rows(other)[:, 4]).max() > 1e-4
    assert np.abs(rows(first)[:, 4] - rows(elsewhere)[:, 4]).max() > 1e-4


def test_a_phrase_longer_than_the_model_reads_is_cut_not_an_error(owl: Owlv2) -> None:
    (evidence,) = owl.query(owl.prepare(picture()), ["unheard " * 100])
    assert np.isfinite(rows(evidence)).all()


def test_a_large_picture_is_made_small_before_it_is_padded(owl: Owlv2) -> None:
    """The processor would hold 64 bits for each number of a padded 3,000 x 3,000: 216 MB."""
    image = np.full((200, 3000, 3), 90, dtype=np.uint8)
    image[:, 1000:2000] = (200, 30, 30)
    tracemalloc.start()
    context = owl.prepare(image)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 20_000_000
    (evidence,) = owl.query(context, ["red cup"])
    assert evidence.heatmap.shape == (200, 3000)
    assert rows(evidence)[:, 2].max() > 1000


def test_the_input_size_sets_how_many_patches_are_seen(owlv2_checkpoint: Path) -> None:
    larger = Owlv2.load(ModelConfig(threads=1, input_size=96), str(owlv2_checkpoint), "{}")
    context = larger.prepare(picture())
    assert context.features.shape[1] == (96 // 16) ** 2
    assert len(context.boxes) == 36


def test_half_precision_answers_nearly_the_same(owl: Owlv2, owlv2_checkpoint: Path) -> None:
    config = ModelConfig(threads=1, dtype="bfloat16")
    half = Owlv2.load(config, str(owlv2_checkpoint), "a photo of a {}")
    (rough,) = half.query(half.prepare(picture()), ["red cup"])
    (exact,) = owl.query(owl.prepare(picture()), ["red cup"])
    np.testing.assert_allclose(rows(rough)[:, 4], rows(exact)[:, 4], atol=0.1)
