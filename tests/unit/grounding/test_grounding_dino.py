"""GroundingDINO through the public loading path, on checkpoints with random weights."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from transformers import AutoModelForZeroShotObjectDetection, GroundingDinoProcessor

from fakes.tiny_models import tiny_grounding_dino
from w2c_grounding.boxes import usable
from w2c_grounding.family import Evidence
from w2c_grounding.grounding_dino import GroundingDino
from w2c_grounding.model_config import ModelConfig

PHRASES = ["red cup", "the book", "green square", "a blue disk", "red"]
Picture = np.ndarray[tuple[int, ...], np.dtype[np.uint8]]


def picture(seed: int = 0, height: int = 90, width: int = 160) -> Picture:
    noise = np.random.default_rng(seed).integers(0, 255, (height // 10, width // 10, 3))
    return np.repeat(np.repeat(noise, 10, axis=0), 10, axis=1).astype(np.uint8)


@pytest.fixture(scope="module")
def dino(dino_checkpoint: Path) -> GroundingDino:
    return GroundingDino.load(ModelConfig(threads=1), str(dino_checkpoint), "{}")


def best(evidence: Evidence) -> tuple[float, ...]:
    assert evidence.boxes is not None
    return max(evidence.boxes, key=lambda box: box.score)


Found = tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]


def whole_model(checkpoint: Path, image: Picture, texts: Sequence[str]) -> list[Found]:
    """Return span scores (queries,) and corner boxes (queries, 4) of the unchanged model.

    One text at a time, through the public pre- and post-processing.
    """
    processor = GroundingDinoProcessor.from_pretrained(checkpoint)
    model = AutoModelForZeroShotObjectDetection.from_pretrained(checkpoint, dtype=torch.float32)
    model.eval()
    found = []
    for text in texts:
        inputs = processor(images=image, text=text, return_tensors="pt")
        with torch.inference_mode():
            outputs = model(**inputs)
        (result,) = processor.post_process_grounded_object_detection(
            outputs, threshold=0.0, text_threshold=0.0, target_sizes=[image.shape[:2]]
        )
        tokens = processor.tokenizer.convert_ids_to_tokens(inputs["input_ids"][0])
        span = slice(1, tokens.index("."))
        assert tokens[0] == "[CLS]"
        assert tokens[span] == text[:-1].split()
        scores = outputs.logits[0, :, span].amax(dim=1).sigmoid()
        found.append((scores.numpy(), result["boxes"].numpy()))
    return found


@pytest.mark.parametrize("mm", [False, True], ids=["grounding-dino", "mm-grounding-dino"])
def test_the_backbone_once_gives_what_the_whole_model_gives(
    dino: GroundingDino, dino_checkpoint: Path, tmp_path: Path, mm: bool
) -> None:
    """The score of a query is that of its best token among the words of the phrase, no others."""
    checkpoint = tiny_grounding_dino(tmp_path, mm=True) if mm else dino_checkpoint
    family = GroundingDino.load(ModelConfig(threads=1), str(checkpoint), "{}") if mm else dino
    evidence = family.query(family.prepare(picture()), PHRASES)
    texts = [phrase + "." for phrase in PHRASES]
    expected = whole_model(checkpoint, picture(), texts)
    for one, (scores, boxes) in zip(evidence, expected, strict=True):
        assert one.boxes is not None
        # Not in order: some scores are nearly the same.
        ours = np.array(one.boxes)  # (queries, 5)
        theirs = np.column_stack([boxes, scores])
        differences = np.abs(ours[:, None, :] - theirs[None, :, :]).max(axis=2)
        np.testing.assert_allclose(differences.min(axis=0), 0.0, atol=0.02)
        np.testing.assert_allclose(differences.min(axis=1), 0.0, atol=0.02)


def test_phrases_together_give_what_each_gives_alone(dino: GroundingDino) -> None:
    context = dino.prepare(picture())
    for phrase, expected in zip(PHRASES, dino.query(context, PHRASES), strict=True):
        (alone,) = dino.query(context, [phrase])
        assert best(alone) == pytest.approx(best(expected), abs=1e-3)


def test_boxes_lie_in_the_picture_and_the_heatmap_shows_them(dino: GroundingDino) -> None:
    (evidence,) = dino.query(dino.prepare(picture()), ["red cup"])
    assert evidence.heatmap.shape == (90, 160)
    sound, dropped = usable(evidence.boxes or (), 160, 90)
    assert sound
    assert dropped == 0
    assert float(evidence.heatmap.max()) == pytest.approx(sound[0].score)


def test_picture_and_phrase_both_matter(dino: GroundingDino) -> None:
    first, other = dino.query(dino.prepare(picture(0)), ["book", "cup"])
    (elsewhere,) = dino.query(dino.prepare(picture(1)), ["book"])
    assert best(first) != pytest.approx(best(other), abs=1e-4)
    assert best(first) != pytest.approx(best(elsewhere), abs=1e-4)


@pytest.mark.parametrize("phrase", ["3.5 inch disk.", "red cup. blue book", "Red Cup?"])
def test_dots_in_a_phrase_do_not_split_it(dino: GroundingDino, phrase: str) -> None:
    clean = phrase.lower().replace(".", " ").replace("?", " ")
    context = dino.prepare(picture())
    (dotted,), (plain,) = dino.query(context, [phrase]), dino.query(context, [clean])
    assert best(dotted) == best(plain)


def test_a_phrase_longer_than_the_model_reads_is_cut_not_an_error(dino: GroundingDino) -> None:
    (evidence,) = dino.query(dino.prepare(picture()), ["red " * 250])
    assert np.isfinite(evidence.heatmap).all()


def test_words_it_cannot_read_are_named_and_alone_find_nothing(dino: GroundingDino) -> None:
    context = dino.prepare(picture())
    mixed, foreign, articles = dino.query(context, ["red 茶碗", "the чашка", "the"])
    assert mixed.unknown_words == ("茶碗",)
    assert mixed.boxes
    assert foreign.unknown_words == ("чашка",)
    assert foreign.boxes == ()
    assert not foreign.heatmap.any()
    assert articles.boxes == ()


def test_more_phrases_than_a_batch_holds_come_back_in_order(dino: GroundingDino) -> None:
    context = dino.prepare(picture())
    many = [PHRASES[index % 5] for index in range(13)]
    singles = {phrase: best(dino.query(context, [phrase])[0]) for phrase in PHRASES}
    for phrase, evidence in zip(many, dino.query(context, many), strict=True):
        assert best(evidence) == pytest.approx(singles[phrase], abs=1e-3)


def test_the_input_size_scales_the_shorter_side(dino_checkpoint: Path) -> None:
    config = ModelConfig(threads=1, input_size=32)
    small = GroundingDino.load(config, str(dino_checkpoint), "{}")
    context = small.prepare(picture())
    assert (context.input_height, context.input_width) == (30, 53)
    assert small.prepare(picture(0, 90, 120)).input_height == 32


def test_half_precision_answers_nearly_the_same(dino: GroundingDino, dino_checkpoint: Path) -> None:
    config = ModelConfig(threads=1, dtype="bfloat16")
    half = GroundingDino.load(config, str(dino_checkpoint), "{}")
    (rough,) = half.query(half.prepare(picture()), ["red cup"])
    (exact,) = dino.query(dino.prepare(picture()), ["red cup"])
    assert best(rough)[4] == pytest.approx(best(exact)[4], abs=0.05)
