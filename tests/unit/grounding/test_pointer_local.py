"""A talking model in this process, on a checkpoint that learned one sentence by heart."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image
from tokenizers import Tokenizer, decoders, models, pre_tokenizers

from w2c.errors import ConfigError, ModelError
from w2c.messages import GroundingRequest
from w2c_grounding.answer import Grounder
from w2c_grounding.guard import Guarded
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.pointer.loading import load_server
from w2c_grounding.pointer.local import LocalTalker
from w2c_grounding.pointer.options import PointerOptions
from w2c_grounding.pointer.pointer import Pointer
from w2c_grounding.registry import load

TEMPLATE = "Point to {}."
ANSWER = "(250, 500)"
CHAT = (
    "{% for m in messages %}{{ m['role'] }}: {% for c in m['content'] %}"
    "{% if c['type'] == 'image' %}<image>{% else %}{{ c['text'] }}{% endif %}"
    "{% endfor %} {% endfor %}{% if add_generation_prompt %}assistant: {% endif %}"
)


def new_processor() -> Any:
    from transformers import CLIPImageProcessorPil, LlavaProcessor, PreTrainedTokenizerFast

    letters = sorted(pre_tokenizers.ByteLevel.alphabet())
    names = ["<pad>", "<s>", "</s>", "<image>", *letters]
    inner = Tokenizer(models.BPE(vocab={name: i for i, name in enumerate(names)}, merges=[]))
    inner.pre_tokenizer = pre_tokenizers.ByteLevel(add_prefix_space=False)
    inner.decoder = decoders.ByteLevel()
    make: Any = PreTrainedTokenizerFast
    tokenizer = make(
        tokenizer_object=inner, pad_token="<pad>", bos_token="<s>", eos_token="</s>",
        extra_special_tokens={"image_token": "<image>"},
    )  # fmt: skip
    images: Any = CLIPImageProcessorPil
    build: Any = LlavaProcessor
    return build(
        image_processor=images(size={"height": 32, "width": 32}, do_center_crop=False),
        tokenizer=tokenizer,
        patch_size=16,
        vision_feature_select_strategy="default",
        num_additional_image_tokens=1,
        image_token="<image>",
        chat_template=CHAT,
    )


def new_model(processor: Any) -> Any:
    from transformers import CLIPVisionConfig, LlamaConfig, LlavaConfig
    from transformers import LlavaForConditionalGeneration as Model

    small: dict[str, Any] = {
        "hidden_size": 32, "intermediate_size": 64, "num_hidden_layers": 2,
        "num_attention_heads": 2,
    }  # fmt: skip
    config = LlavaConfig(
        vision_config=CLIPVisionConfig(**small, image_size=32, patch_size=16),
        text_config=LlamaConfig(
            **small, vocab_size=len(processor.tokenizer), num_key_value_heads=2, bos_token_id=1,
            eos_token_id=2, pad_token_id=0, max_position_embeddings=512,
        ),
        image_token_index=processor.tokenizer.convert_tokens_to_ids("<image>"),
        vision_feature_layer=-1,
    )  # fmt: skip
    return Model(config)


def teach(model: Any, processor: Any) -> None:
    """Let it learn by heart what it is to say."""
    asked = [{"type": "image"}, {"type": "text", "text": TEMPLATE.format("cup")}]
    prompt = processor.apply_chat_template(
        [{"role": "user", "content": asked}], add_generation_prompt=True
    )
    grey = Image.new("RGB", (320, 180), (128, 128, 128))
    inputs = processor(text=[f"{prompt}{ANSWER}</s>"], images=[grey], return_tensors="pt")
    labels = inputs["input_ids"].clone()
    labels[:, : -len(ANSWER) - 1] = -100
    optimizer = torch.optim.Adam(model.parameters(), lr=0.01)
    for _ in range(60):
        optimizer.zero_grad()
        loss = model(**inputs, labels=labels).loss
        loss.backward()
        optimizer.step()
    assert loss < 0.1


@pytest.fixture(scope="module")
def checkpoint(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("talker")
    torch.manual_seed(3)
    torch.set_num_threads(1)
    processor = new_processor()
    model = new_model(processor)
    teach(model, processor)
    model.save_pretrained(directory)
    processor.save_pretrained(directory)
    return directory


def picture() -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(np.full((180, 320, 3), 128, dtype=np.uint8)).save(buffer, format="PNG")
    return buffer.getvalue()


def test_a_checkpoint_that_talks_is_recognised_asked_and_read(checkpoint: Path) -> None:
    options = PointerOptions(max_tokens=20)
    config = ModelConfig(model=str(checkpoint), template=TEMPLATE, threads=1, pointer=options)
    family, card = load(config)
    assert isinstance(family, Guarded)
    assert isinstance(family.family, Pointer)
    family.family.warm_up()
    request = GroundingRequest(jpeg=picture(), phrases=["cup"], want="boxes")
    (answer,) = Grounder(family, card).ground(request).evidence
    assert answer.found
    assert answer.point == pytest.approx((80, 90), abs=1)
    family.family.close()


def test_a_checkpoint_without_a_chat_template_cannot_be_asked(
    checkpoint: Path, tmp_path: Path
) -> None:
    for file in checkpoint.iterdir():
        if file.suffix != ".jinja":
            (tmp_path / file.name).write_bytes(file.read_bytes())
    with pytest.raises(ModelError, match="has no chat template"):
        LocalTalker.load(ModelConfig(threads=1), str(tmp_path), PointerOptions())


def test_a_server_needs_an_address_and_the_name_of_a_model() -> None:
    for config in (
        ModelConfig(family="pointer", model="eye"),
        ModelConfig(family="pointer", pointer=PointerOptions(url="http://127.0.0.1:9/v1")),
    ):
        with pytest.raises(ConfigError, match=r"--pointer\.url.* and --model"):
            load(config)


def test_a_server_is_not_asked_before_the_first_question(tmp_path: Path) -> None:
    key = tmp_path / "key"
    key.write_text("sk-secret\n")
    options = PointerOptions(url="http://127.0.0.1:9/v1", key_file=str(key))
    family, card = load(ModelConfig(family="pointer", model="org/eye:7b", pointer=options))
    assert card.name == "org/eye:7b"
    assert isinstance(family, Guarded)
    assert isinstance(family.family, Pointer)
    family.family.warm_up()
    family.family.close()
    with pytest.raises(ConfigError, match="key file"):
        load_server(
            ModelConfig(pointer=PointerOptions(url="http://x/v1", key_file="/nowhere")), "m", "{}"
        )
