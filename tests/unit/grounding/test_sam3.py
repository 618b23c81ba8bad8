"""SAM 3: on a model with random weights of transformers' own class, and without torchvision."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from w2c.errors import ConfigError
from w2c_grounding.evidence import find
from w2c_grounding.family import RgbImage
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import FAMILIES
from w2c_grounding.sam3 import MAX_INSTANCES, Sam3, evidence_of
from w2c_grounding.torchvision_build import need_torchvision

WIDTH, HEIGHT, QUERIES = 320, 180, 25


def picture(seed: int = 0) -> RgbImage:
    noise = np.random.default_rng(seed).integers(0, 255, (9, 16, 3), dtype=np.uint8)
    return np.repeat(np.repeat(noise, 20, axis=0), 20, axis=1)


class Preparation:
    """What the processor does, which torchvision is needed for: the letters are the tokens."""

    def image_processor(self, images: RgbImage, return_tensors: str) -> dict[str, torch.Tensor]:
        pixels = torch.from_numpy(images).permute(2, 0, 1)[None].float() / 127.5 - 1.0
        return {"pixel_values": torch.nn.functional.interpolate(pixels, (56, 56))}

    def tokenizer(self, texts: list[str], **options: Any) -> Any:
        from transformers import BatchEncoding

        assert options["max_length"] == 32
        rows = [[1, *(ord(letter) % 90 + 2 for letter in text[:30]), 99] for text in texts]
        masks = [[1] * len(row) + [0] * (32 - len(row)) for row in rows]
        ids = [row + [0] * (32 - len(row)) for row in rows]
        return BatchEncoding(
            {"input_ids": torch.tensor(ids), "attention_mask": torch.tensor(masks)}
        )


@pytest.fixture(scope="module")
def sam3() -> Sam3:
    from transformers.models.sam3.configuration_sam3 import Sam3Config
    from transformers.models.sam3.modeling_sam3 import Sam3Model

    torch.manual_seed(3)
    torch.set_num_threads(1)
    small = {"hidden_size": 32, "num_attention_heads": 2, "intermediate_size": 32}
    config = Sam3Config(
        vision_config={
            "backbone_config": {
                **small, "model_type": "sam3_vit_model", "num_hidden_layers": 2, "image_size": 56,
                "pretrain_image_size": 28, "window_size": 2, "global_attn_indexes": [1],
            },
            "fpn_hidden_size": 32,
            "backbone_feature_sizes": [[16, 16], [8, 8], [4, 4]],
        },
        text_config={
            **small, "vocab_size": 100, "projection_dim": 16, "num_hidden_layers": 1,
            "max_position_embeddings": 32, "eos_token_id": 99, "bos_token_id": 1,
        },
        geometry_encoder_config={**small, "num_layers": 1},
        detr_encoder_config={**small, "num_layers": 1},
        detr_decoder_config={**small, "num_layers": 1, "num_queries": QUERIES},
        mask_decoder_config={"hidden_size": 32, "num_attention_heads": 2},
    )  # fmt: skip
    return Sam3(Sam3Model(config), Preparation(), "{}")


def test_instances_have_boxes_and_masks_over_the_whole_picture(sam3: Sam3) -> None:
    (evidence,) = sam3.query(sam3.prepare(picture()), ["cup"])
    assert evidence.heatmap.shape == (HEIGHT, WIDTH)
    assert evidence.heatmap.max() > 0.0
    assert evidence.boxes is not None
    assert len(evidence.boxes) == MAX_INSTANCES
    scores = [box.score for box in evidence.boxes]
    assert scores == sorted(scores, reverse=True)
    assert all(0.0 <= box.left <= WIDTH and 0.0 <= box.bottom <= HEIGHT for box in evidence.boxes)


def test_the_image_tower_once_gives_what_the_whole_model_gives(sam3: Sam3) -> None:
    prepared = Preparation()
    tokens = prepared.tokenizer(["red cup"], max_length=32)
    with torch.inference_mode():
        output = sam3._model(
            pixel_values=prepared.image_processor(picture(), "pt")["pixel_values"], **tokens
        )
    scores = (output.pred_logits[0].sigmoid() * output.presence_logits[0].sigmoid()).numpy()
    (evidence,) = sam3.query(sam3.prepare(picture()), ["red cup"])
    assert evidence.boxes is not None
    assert evidence.boxes[0].score == pytest.approx(float(scores.max()), abs=1e-5)
    left, top, right, bottom = output.pred_boxes[0, int(scores.argmax())].tolist()
    assert evidence.boxes[0][:4] == pytest.approx(
        (left * WIDTH, top * HEIGHT, right * WIDTH, bottom * HEIGHT), abs=0.01
    )


def test_picture_and_phrase_both_matter_and_phrases_do_not_mix(sam3: Sam3) -> None:
    context = sam3.prepare(picture(0))
    cup, book = sam3.query(context, ["cup", "a wooden book"])
    (alone,) = sam3.query(context, ["a wooden book"])
    (elsewhere,) = sam3.query(sam3.prepare(picture(1)), ["cup"])
    np.testing.assert_allclose(book.heatmap, alone.heatmap, atol=1e-6)
    assert np.abs(cup.heatmap - book.heatmap).max() > 1e-6
    assert np.abs(cup.heatmap - elsewhere.heatmap).max() > 1e-6


def test_masks_and_boxes_become_one_evidence() -> None:
    masks = np.zeros((2, 18, 32), dtype=np.float32)
    masks[0, 9:18, 0:16] = 1.0
    masks[1, 0:4, 20:30] = 1.0
    boxes = np.array([[0.0, 0.5, 0.5, 1.0], [0.625, 0.0, 0.9375, 0.2]], dtype=np.float32)
    scores = np.array([0.9, 0.2], dtype=np.float32)
    evidence = evidence_of(scores, boxes, masks, WIDTH, HEIGHT)
    finding = find(evidence.heatmap, 0.5, "interior", evidence.boxes)
    assert len(finding.regions) == 1
    assert finding.point == pytest.approx((80, 135), abs=12)
    assert evidence.heatmap[10, 250] == pytest.approx(0.2, abs=0.01)


def test_without_torchvision_the_error_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torchvision", None)
    with pytest.raises(ConfigError, match=r"sam3 needs torchvision, which is not .*pip install"):
        Sam3.load(ModelConfig(), "facebook/sam3", "{}")


def test_a_torchvision_that_does_not_fit_is_told_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "torchvision.py").write_text('raise RuntimeError("no operator torchvision::nms")')
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "torchvision", raising=False)
    with pytest.raises(ConfigError, match=r"does not fit torch .*torchvision::nms"):
        need_torchvision("this")


def test_one_that_fits_is_enough(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "torchvision.py").write_text("")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "torchvision", raising=False)
    need_torchvision("this")
    monkeypatch.delitem(sys.modules, "torchvision")


def test_its_checkpoints_are_recognised() -> None:
    assert "sam3_video" in FAMILIES["sam3"].model_types
