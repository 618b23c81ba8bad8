"""Florence-2 through the public loading path, on a checkpoint that learned two sentences."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from w2c.errors import ModelError
from w2c_grounding.family import RgbImage
from w2c_grounding.florence import Florence
from w2c_grounding.florence_answer import BINS, Location, boxes_of, polygons_of
from w2c_grounding.model_config import ModelConfig

WIDTH, HEIGHT = 320, 180
BOX = "<loc_100><loc_200><loc_300><loc_400>"
TRIANGLE = "<loc_500><loc_500><loc_900><loc_500><loc_500><loc_900>"


def picture(seed: int = 0) -> RgbImage:
    noise = np.random.default_rng(seed).integers(0, 255, (9, 16, 3), dtype=np.uint8)
    return np.repeat(np.repeat(noise, 20, axis=0), 20, axis=1)


def tiny_processor() -> Any:
    """Return a processor with a byte vocabulary, the location tokens, and 64 px pictures."""
    from transformers import BartTokenizer, CLIPImageProcessorPil, Florence2Processor
    from transformers.convert_slow_tokenizer import bytes_to_unicode

    alphabet: Any = bytes_to_unicode  # untyped
    names = ["<s>", "<pad>", "</s>", "<unk>", "<mask>", *alphabet().values()]
    tokenizer: Any = BartTokenizer(
        vocab={name: index for index, name in enumerate(names)},
        merges=[],
        extra_special_tokens={"image_token": "<image>"},
    )
    tokenizer.add_tokens([f"<loc_{index}>" for index in range(BINS)])
    make: Any = CLIPImageProcessorPil
    images = make(size={"height": 64, "width": 64}, do_center_crop=False, do_convert_rgb=True)
    images.image_seq_length = (64 // 32) ** 2 + 1
    return Florence2Processor(image_processor=images, tokenizer=tokenizer)


def tiny_model(processor: Any) -> Any:
    from transformers import BartConfig, Florence2Config, Florence2ForConditionalGeneration
    from transformers.models.florence2.configuration_florence2 import Florence2VisionConfig

    tokenizer = processor.tokenizer
    vision = Florence2VisionConfig(
        depths=[1, 1, 1, 1],
        embed_dim=[16, 16, 16, 16],
        num_heads=[2, 2, 2, 2],
        num_groups=[2, 2, 2, 2],
        window_size=2,
        projection_dim=32,
        drop_path_rate=0.0,
    )
    text = BartConfig(
        vocab_size=len(tokenizer),
        d_model=32,
        encoder_layers=1,
        decoder_layers=1,
        encoder_attention_heads=2,
        decoder_attention_heads=2,
        encoder_ffn_dim=64,
        decoder_ffn_dim=64,
        max_position_embeddings=128,
        dropout=0.0,
        bos_token_id=0,
        pad_token_id=1,
        eos_token_id=2,
        decoder_start_token_id=2,
    )
    config = Florence2Config(
        vision_config=vision,
        text_config=text,
        image_token_id=tokenizer.convert_tokens_to_ids("<image>"),
    )
    return Florence2ForConditionalGeneration(config)


def teach(model: Any, processor: Any) -> None:
    """Let it learn by heart what it is to say of one picture."""
    prompts = [
        "<OPEN_VOCABULARY_DETECTION>red cup",
        "<OPEN_VOCABULARY_DETECTION>unicorn",
        "<REFERRING_EXPRESSION_SEGMENTATION>red cup",
    ]
    answers = [f"red cup{BOX}{BOX[:-9]}<loc_999>", "", TRIANGLE]
    inputs = processor(text=prompts, images=[picture()] * 3, padding=True, return_tensors="pt")
    labels = processor.tokenizer(
        [f"<s>{answer}</s>" for answer in answers],
        add_special_tokens=False,
        padding=True,
        return_tensors="pt",
    )["input_ids"]
    labels[labels == processor.tokenizer.pad_token_id] = -100
    # The image tower stays as it is: it takes most of the time, and the language model can learn it
    # all by heart.
    with torch.no_grad():
        seen = model.get_image_features(pixel_values=inputs["pixel_values"]).pooler_output
    slots = (inputs["input_ids"] == model.config.image_token_id).unsqueeze(-1)
    optimizer = torch.optim.Adam(model.parameters(), lr=0.01)
    for _ in range(70):
        optimizer.zero_grad()
        words = model.get_input_embeddings()(inputs["input_ids"])
        answer = model(
            inputs_embeds=words.masked_scatter(slots, seen),
            attention_mask=inputs["attention_mask"],
            labels=labels,
        )
        loss = answer.loss
        loss.backward()
        optimizer.step()
    assert loss < 0.1


@pytest.fixture(scope="module")
def checkpoint(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("florence")
    torch.manual_seed(3)
    torch.set_num_threads(1)
    processor = tiny_processor()
    model = tiny_model(processor)
    teach(model.train(), processor)
    model.save_pretrained(directory)
    processor.save_pretrained(directory)
    return directory


def load(checkpoint: Path, task: str = "boxes", **config: Any) -> Florence:
    return Florence.load(ModelConfig(threads=1, **config), str(checkpoint), "{}", task)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def florence(checkpoint: Path) -> Florence:
    return load(checkpoint)


def test_boxes_are_in_pixels_of_the_picture_with_the_certainty_of_the_model(
    florence: Florence,
) -> None:
    (evidence,) = florence.query(florence.prepare(picture()), ["red cup"])
    assert evidence.boxes is not None
    first, second = evidence.boxes
    assert first[:4] == pytest.approx((32.16, 36.09, 96.16, 72.09))
    assert second.bottom == pytest.approx(179.9, abs=0.1)
    assert 0.5 < first.score <= 1.0
    assert evidence.heatmap[50, 60] > 0.4
    assert evidence.heatmap[50, 200] == 0.0


def test_a_model_that_writes_no_place_has_not_found_it(florence: Florence) -> None:
    (evidence,) = florence.query(florence.prepare(picture()), ["unicorn"])
    assert evidence.boxes == ()
    assert not evidence.heatmap.any()


def test_outlines_become_a_heatmap(checkpoint: Path) -> None:
    florence = load(checkpoint, "outlines")
    (evidence,) = florence.query(florence.prepare(picture()), ["red cup"])
    assert evidence.boxes is None
    assert evidence.heatmap[100, 180] > 0.4
    assert evidence.heatmap[170, 280] == 0.0, "the triangle's long side runs between"


def test_phrases_together_get_what_each_gets_alone(florence: Florence) -> None:
    context = florence.prepare(picture())
    phrases = ["red cup", "unicorn", "a much longer phrase of many words", "red cup"] * 3
    together = florence.query(context, phrases)
    for phrase, expected in zip(phrases[:4], together, strict=False):
        (alone,) = florence.query(context, [phrase])
        np.testing.assert_allclose(alone.heatmap, expected.heatmap, atol=1e-4)
    assert len(together) == 12


def test_the_image_tower_once_writes_what_the_whole_model_writes(
    florence: Florence, checkpoint: Path
) -> None:
    from transformers import AutoProcessor, Florence2ForConditionalGeneration

    load_any: Any = AutoProcessor  # untyped
    processor = load_any.from_pretrained(checkpoint, backend="pil")
    model: Any = Florence2ForConditionalGeneration.from_pretrained(checkpoint)
    inputs = processor(
        text="<OPEN_VOCABULARY_DETECTION>red cup", images=picture(1), return_tensors="pt"
    )
    written = model.generate(**inputs, max_new_tokens=40, num_beams=1, do_sample=False)
    bins = [florence._bins.get(token) for token in written[0, 1:].tolist()]
    expected = boxes_of([b if b is None else Location(b, 1.0) for b in bins], WIDTH, HEIGHT)
    (evidence,) = florence.query(florence.prepare(picture(1)), ["red cup"])
    assert evidence.boxes
    assert [box[:4] for box in evidence.boxes] == [box[:4] for box in expected]


@pytest.mark.parametrize("dtype", ["bfloat16", "float16"])
def test_half_precision_writes_the_same(checkpoint: Path, dtype: str) -> None:
    half = load(checkpoint, dtype=dtype)
    (evidence,) = half.query(half.prepare(picture()), ["red cup"])
    assert evidence.boxes is not None
    assert evidence.boxes[0][:4] == pytest.approx((32.16, 36.09, 96.16, 72.09))


def test_a_tokenizer_without_locations_is_refused(checkpoint: Path, tmp_path: Path) -> None:
    for file in checkpoint.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    tokenizer = json.loads((tmp_path / "tokenizer.json").read_text())
    tokenizer["added_tokens"] = [
        token for token in tokenizer["added_tokens"] if token["content"] != "<loc_7>"
    ]
    (tmp_path / "tokenizer.json").write_text(json.dumps(tokenizer))
    with pytest.raises(ModelError, match="location tokens"):
        load(tmp_path)


LOCATION = st.builds(Location, st.integers(0, BINS - 1), st.floats(0.0, 1.0))


@given(st.lists(st.tuples(LOCATION, LOCATION, LOCATION, LOCATION), max_size=6), st.booleans())
@settings(max_examples=40)
def test_every_whole_box_that_is_written_is_read(
    boxes: list[tuple[Location, ...]], words_between: bool
) -> None:
    tokens: list[Location | None] = [None]
    for box in boxes:
        tokens += [*box, None] if words_between else box
    found = boxes_of([*tokens, *[Location(5, 0.5)] * 3], 1000, 2000)
    assert len(found) == len(boxes)
    for written, read in zip(boxes, found, strict=True):
        left, top, right, bottom = (location.bin + 0.5 for location in written)
        assert read[:4] == pytest.approx((left, 2 * top, right, 2 * bottom))
        assert 0.0 <= read.score <= 1.0


@given(st.lists(st.lists(LOCATION, max_size=9), max_size=5))
@settings(max_examples=40)
def test_polygons_are_separated_and_have_three_corners(runs: list[list[Location]]) -> None:
    tokens: list[Location | None] = []
    for run in runs:
        tokens += [*run, None]
    polygons, scores = polygons_of(tokens, WIDTH, HEIGHT)
    assert [len(polygon) for polygon in polygons] == [len(r) // 2 for r in runs if len(r) >= 6]
    assert len(scores) == len(polygons)


def test_a_model_that_repeats_itself_is_cut_off() -> None:
    endless = [Location(1, 1.0)] * 4000
    assert len(boxes_of(endless, WIDTH, HEIGHT)) == 50
