"""CLIP Surgery on an unchanged CLIP with random weights."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from transformers import CLIPModel

from w2c_grounding.clip_surgery import (
    SURGERY_BLOCKS,
    TEMPLATES,
    ClipSurgery,
    ClipSurgeryContext,
    surgery_tokens,
    value_attention,
)
from w2c_grounding.model_config import ModelConfig

Picture = np.ndarray[tuple[int, ...], np.dtype[np.uint8]]


def picture(seed: int = 0) -> Picture:
    noise = np.random.default_rng(seed).integers(0, 255, (9, 16, 3))
    return np.repeat(np.repeat(noise, 10, axis=0), 10, axis=1).astype(np.uint8)


@pytest.fixture(scope="module")
def model(clip_checkpoint: Path) -> Any:
    model: Any = CLIPModel.from_pretrained(clip_checkpoint, dtype=torch.float32)
    return model.eval()


@pytest.fixture(scope="module")
def surgery(clip_checkpoint: Path) -> ClipSurgery:
    return ClipSurgery.load(ModelConfig(threads=1), str(clip_checkpoint), "{}")


@pytest.fixture(scope="module")
def pixels() -> torch.Tensor:
    return torch.randn(2, 3, 64, 64, generator=torch.Generator().manual_seed(0))


def test_the_class_token_is_that_of_the_original(model: Any, pixels: torch.Tensor) -> None:
    with torch.inference_mode():
        expected = model.get_image_features(pixel_values=pixels).pooler_output
        tokens = surgery_tokens(model, pixels)
    torch.testing.assert_close(tokens[:, 0], expected, atol=1e-5, rtol=1e-5)


def test_value_attention_relates_tokens_by_their_values_alone(model: Any) -> None:
    """Against the formula, head by head and token by token."""
    attention = model.vision_model.encoder.layers[0].self_attn
    hidden = torch.randn(1, 5, 32, generator=torch.Generator().manual_seed(1))
    with torch.inference_mode():
        found = value_attention(attention, hidden)[0].numpy()
        values = attention.v_proj(hidden)[0].double().numpy()
        mixed = np.zeros_like(values)
        width = attention.head_dim
        for head in range(attention.num_heads):
            v = values[:, head * width : (head + 1) * width]
            for token in range(len(v)):
                weights = np.exp(v @ v[token] / np.sqrt(width))
                mixed[token, head * width : (head + 1) * width] = weights @ v / weights.sum()
        expected = attention.out_proj(torch.tensor(mixed, dtype=torch.float32)).numpy()
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_patches_gather_value_attention_of_the_last_blocks_and_no_feed_forward(
    model: Any, pixels: torch.Tensor
) -> None:
    """Against hidden states that the unchanged model reports of itself."""
    with torch.inference_mode():
        tower = model.vision_model
        states = tower(pixels, output_hidden_states=True).hidden_states
        start = len(tower.encoder.layers) - SURGERY_BLOCKS
        assert start == 2
        stream = states[start].clone()
        for index in range(start, len(tower.encoder.layers)):
            block = tower.encoder.layers[index]
            stream += value_attention(block.self_attn, block.layer_norm1(states[index]))
        expected = model.visual_projection(tower.post_layernorm(stream))
        found = surgery_tokens(model, pixels)
    torch.testing.assert_close(found[:, 1:], expected[:, 1:], atol=1e-5, rtol=1e-5)


def test_the_map_is_the_similarity_to_the_phrase_less_that_to_nothing(
    surgery: ClipSurgery, model: Any
) -> None:
    """Feature surgery for one text, each feature of length 1 over its channels."""
    context = surgery.prepare(picture())
    lengths = context.patches.norm(dim=-1)
    torch.testing.assert_close(lengths, torch.ones_like(lengths))
    texts = {}
    for phrase in ("red cup", ""):
        tokens = surgery._processor.tokenizer(
            [template.replace("{}", phrase) for template in TEMPLATES],
            padding=True,
            return_tensors="pt",
        )
        with torch.inference_mode():
            features = model.get_text_features(**tokens).pooler_output.numpy()
        features /= np.linalg.norm(features, axis=1, keepdims=True)
        texts[phrase] = features.mean(axis=0) / np.linalg.norm(features.mean(axis=0))
    patches = context.patches.numpy()
    expected = patches @ texts["red cup"] - patches @ texts[""]  # (4, 4)
    (evidence,) = surgery.query(context, ["red cup"])
    # 160 x 90 px from 4 x 4 patches: these pixels lie nearest to the centres of patches.
    found = evidence.heatmap[11:90:22, 19:160:40][:4, :4]
    assert np.corrcoef(found.ravel(), expected.ravel())[0, 1] > 0.98
    presence = 1 / (1 + np.exp(-expected.max() * np.exp(model.logit_scale.item())))
    assert float(evidence.heatmap.max()) == pytest.approx(presence, rel=0.02)
    assert evidence.heatmap.min() == pytest.approx(0.0, abs=0.02)


def test_no_phrase_influences_another(surgery: ClipSurgery) -> None:
    context = surgery.prepare(picture())
    together = surgery.query(context, ["red cup", "book", "blue disk"])
    for phrase, expected in zip(["red cup", "book", "blue disk"], together, strict=True):
        (alone,) = surgery.query(context, [phrase])
        np.testing.assert_allclose(alone.heatmap, expected.heatmap, atol=1e-5)


def test_picture_and_phrase_both_matter(surgery: ClipSurgery) -> None:
    first, other = surgery.query(surgery.prepare(picture(0)), ["book", "cup"])
    (elsewhere,) = surgery.query(surgery.prepare(picture(1)), ["book"])
    assert np.abs(first.heatmap - other.heatmap).max() > 1e-3
    assert np.abs(first.heatmap - elsewhere.heatmap).max() > 1e-3


def test_a_picture_without_contrast_is_an_answer(surgery: ClipSurgery) -> None:
    grey = np.full((90, 160, 3), 128, dtype=np.uint8)
    for evidence in surgery.query(surgery.prepare(grey), ["red cup", "unheard " * 100]):
        assert np.isfinite(evidence.heatmap).all()
        assert 0.0 <= evidence.heatmap.min() <= evidence.heatmap.max() <= 1.0


def test_patches_that_are_all_alike_are_an_answer(surgery: ClipSurgery) -> None:
    alike = ClipSurgeryContext(160, 90, torch.full((4, 4, 32), 32**-0.5))
    (evidence,) = surgery.query(alike, ["red cup"])
    assert not evidence.heatmap.any()


def test_the_input_size_sets_how_many_patches_are_seen(clip_checkpoint: Path) -> None:
    larger = ClipSurgery.load(ModelConfig(threads=1, input_size=96), str(clip_checkpoint), "{}")
    assert larger.prepare(picture()).patches.shape[:2] == (6, 6)


def test_half_precision_answers_nearly_the_same(
    surgery: ClipSurgery, clip_checkpoint: Path
) -> None:
    config = ModelConfig(threads=1, dtype="bfloat16")
    half = ClipSurgery.load(config, str(clip_checkpoint), "{}")
    (rough,) = half.query(half.prepare(picture()), ["red cup"])
    (exact,) = surgery.query(surgery.prepare(picture()), ["red cup"])
    assert np.corrcoef(rough.heatmap.ravel(), exact.heatmap.ravel())[0, 1] > 0.98
