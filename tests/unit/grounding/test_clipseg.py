"""CLIPSeg through the public loading path, on a checkpoint with random weights."""

import json
from pathlib import Path

import numpy as np
import pytest
import torch
from transformers import CLIPSegForImageSegmentation, CLIPSegProcessor

from w2c_grounding.clipseg import ClipSeg
from w2c_grounding.evidence import heatmap_from_logits
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.train.tokens import learn_merges, make_vocabulary

PHRASES = ["book", "the red cup", "a blue elephant on the book"]


def picture(seed: int = 0) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    noise = np.random.default_rng(seed).integers(0, 255, (9, 16, 3), dtype=np.uint8)
    return np.repeat(np.repeat(noise, 20, axis=0), 20, axis=1)


@pytest.fixture(scope="module")
def clipseg(tiny_checkpoint: Path) -> ClipSeg:
    return ClipSeg.load(ModelConfig(threads=1), str(tiny_checkpoint), "{}")


def test_heatmaps_are_probabilities_at_the_size_of_the_picture(clipseg: ClipSeg) -> None:
    evidence = clipseg.query(clipseg.prepare(picture()), PHRASES)
    assert len(evidence) == len(PHRASES)
    for one in evidence:
        assert one.heatmap.shape == (180, 320)
        assert one.heatmap.dtype == np.float32
        assert 0.0 <= one.heatmap.min() < one.heatmap.max() <= 1.0


def test_phrases_together_give_what_each_gives_alone(clipseg: ClipSeg) -> None:
    context = clipseg.prepare(picture())
    together = clipseg.query(context, PHRASES)
    for phrase, expected in zip(PHRASES, together, strict=True):
        (alone,) = clipseg.query(context, [phrase])
        np.testing.assert_allclose(alone.heatmap, expected.heatmap, atol=1e-5)


def test_the_picture_tower_once_gives_what_the_whole_model_gives(
    clipseg: ClipSeg, tiny_checkpoint: Path
) -> None:
    processor = CLIPSegProcessor.from_pretrained(tiny_checkpoint)
    model = CLIPSegForImageSegmentation.from_pretrained(tiny_checkpoint, dtype=torch.float32)
    inputs = processor(
        text=PHRASES,
        images=[picture()] * len(PHRASES),
        padding=True,
        truncation=True,
        return_tensors="pt",
    )
    with torch.inference_mode():
        logits = model(**inputs).logits.numpy()
    evidence = clipseg.query(clipseg.prepare(picture()), PHRASES)
    for one, expected in zip(evidence, logits, strict=True):
        np.testing.assert_allclose(one.heatmap, heatmap_from_logits(expected, 320, 180), atol=1e-5)


def test_picture_and_phrase_both_matter(clipseg: ClipSeg) -> None:
    first = clipseg.query(clipseg.prepare(picture(0)), ["book", "cup"])
    second = clipseg.query(clipseg.prepare(picture(1)), ["book"])
    assert np.abs(first[0].heatmap - first[1].heatmap).max() > 1e-4
    assert np.abs(first[0].heatmap - second[0].heatmap).max() > 1e-4


def test_a_phrase_longer_than_the_model_reads_is_cut_not_an_error(clipseg: ClipSeg) -> None:
    (one,) = clipseg.query(clipseg.prepare(picture()), ["unheard " * 100])
    assert np.isfinite(one.heatmap).all()


@pytest.mark.parametrize("dtype", ["bfloat16", "float16"])
def test_half_precision_answers_nearly_the_same(
    clipseg: ClipSeg, tiny_checkpoint: Path, dtype: str
) -> None:
    config = ModelConfig(threads=1, dtype=dtype)  # type: ignore[arg-type]
    half = ClipSeg.load(config, str(tiny_checkpoint), "{}")
    (rough,) = half.query(half.prepare(picture()), ["book"])
    (exact,) = clipseg.query(clipseg.prepare(picture()), ["book"])
    np.testing.assert_allclose(rough.heatmap, exact.heatmap, atol=0.05)


def test_the_layout_of_the_first_public_checkpoints_loads_too(
    clipseg: ClipSeg, tiny_checkpoint: Path, tmp_path: Path
) -> None:
    """`CIDAS/clipseg-rd64-refined` has vocab.json, merges.txt and preprocessor_config.json."""
    for name in ("config.json", "model.safetensors"):
        (tmp_path / name).write_bytes((tiny_checkpoint / name).read_bytes())
    merges = learn_merges(["the", "red", "blue", "book", "cup"])
    (tmp_path / "vocab.json").write_text(json.dumps(make_vocabulary(merges)))
    lines = ["#version: 0.2", *(" ".join(pair) for pair in merges)]
    (tmp_path / "merges.txt").write_text("\n".join(lines) + "\n")
    (tmp_path / "tokenizer_config.json").write_text(
        json.dumps({"tokenizer_class": "CLIPTokenizer", "model_max_length": 24})
    )
    (tmp_path / "preprocessor_config.json").write_text(
        json.dumps(
            {
                "feature_extractor_type": "ViTFeatureExtractor",
                "do_resize": True,
                "size": 64,
                "resample": 2,
                "do_normalize": True,
                "image_mean": [0.485, 0.456, 0.406],
                "image_std": [0.229, 0.224, 0.225],
            }
        )
    )
    old = ClipSeg.load(ModelConfig(threads=1), str(tmp_path), "{}")
    expected = clipseg.query(clipseg.prepare(picture()), PHRASES)
    for one, other in zip(old.query(old.prepare(picture()), PHRASES), expected, strict=True):
        np.testing.assert_allclose(one.heatmap, other.heatmap, atol=1e-5)
