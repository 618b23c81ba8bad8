"""A small CLIPSeg from nothing, in the layout that `from_pretrained` reads."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch

from w2c.errors import ConfigError
from w2c_grounding.card import ModelCard, write_card
from w2c_grounding.train.tokens import make_tokenizer

# Of the ImageNet pictures, as all CLIPSeg checkpoints have them.
MEAN = (0.485, 0.456, 0.406)
LOUDEST = 9.0
"""Mean square of what enters a layer of the decoder"""
DEVIATION = (0.229, 0.224, 0.225)


@dataclass(frozen=True)
class Size:
    """How large the model is. The defaults are those of the embedded one."""

    image: int = 352
    """The picture is squashed to a square of this side [px]: the decoder knows only squares"""
    patch: int = 16
    width: int = 256
    """Of the picture tower"""
    layers: int = 6
    heads: int = 8
    extract: tuple[int, ...] = (2, 5)
    """Layers whose activations the decoder reads"""
    text_width: int = 128
    text_layers: int = 2
    projection: int = 128
    reduced: int = 64
    """Width of the decoder, the `rd64` of the published checkpoints"""
    longest_phrase: int = 24
    """[tokens]"""

    @property
    def cells(self) -> int:
        """Patches along a side of the picture."""
        return self.image // self.patch


def new_model(size: Size, vocabulary_size: int) -> Any:
    """Return a CLIPSeg with random weights.

    ReLU instead of GELU: an eighth of the time less on a CPU.
    """
    from transformers import CLIPSegConfig, CLIPSegForImageSegmentation

    end = vocabulary_size - 1
    config = CLIPSegConfig(
        text_config={
            "vocab_size": vocabulary_size,
            "hidden_size": size.text_width,
            "intermediate_size": 2 * size.text_width,
            "num_hidden_layers": size.text_layers,
            "num_attention_heads": 4,
            "max_position_embeddings": size.longest_phrase,
            "hidden_act": "relu",
            "bos_token_id": end - 1,
            "eos_token_id": end,
            "pad_token_id": end,
        },
        vision_config={
            "hidden_size": size.width,
            "intermediate_size": 4 * size.width,
            "num_hidden_layers": size.layers,
            "num_attention_heads": size.heads,
            "image_size": size.image,
            "patch_size": size.patch,
            "hidden_act": "relu",
        },
        projection_dim=size.projection,
        reduce_dim=size.reduced,
        extract_layers=list(size.extract),
        decoder_num_attention_heads=2,
        decoder_intermediate_size=3 * size.reduced,
        # A patch of the heatmap from one token at once, as in the published `rd64`: the three
        # convolutions of `rd64-refined` would take more time than the rest of the decoder.
        use_complex_transposed_convolution=False,
    )
    model = CLIPSegForImageSegmentation(config)
    start_decoder(model)
    return model


def start_decoder(model: Any) -> None:
    """Start the decoder's own weights at a usual size, and its heatmaps near "nothing here".

    Without the configuration of a picture tower to look at, transformers draws them with a standard
    deviation of one: published checkpoints never start from there.
    """
    decoder = model.decoder
    for module in decoder.modules():
        if isinstance(module, torch.nn.Linear | torch.nn.Conv2d | torch.nn.ConvTranspose2d):
            torch.nn.init.xavier_uniform_(module.weight)
            if module.bias is not None:
                torch.nn.init.zeros_(module.bias)
    # The first phrase embedding shall scale the features by about one.
    torch.nn.init.ones_(decoder.film_mul.bias)
    torch.nn.init.constant_(decoder.transposed_convolution.bias, -3.0)


def new_processor(size: Size, words: Sequence[str]) -> Any:
    """Return the processor: squash to a square, normalise, tokenize."""
    from transformers import CLIPSegProcessor, ViTImageProcessorPil

    make: Any = CLIPSegProcessor  # untyped

    image_processor = ViTImageProcessorPil(
        size={"height": size.image, "width": size.image},
        resample=2,  # bilinear; Pillow's averages over what it shrinks
        image_mean=list(MEAN),
        image_std=list(DEVIATION),
    )
    return make(
        image_processor=image_processor, tokenizer=make_tokenizer(words, size.longest_phrase)
    )


def features(
    model: Any, pixels: torch.Tensor, corners: torch.Tensor | None = None
) -> tuple[torch.Tensor, ...]:
    """Return the activations (n, 1 + patches, width) that the decoder reads, with gradients.

    Args:
        model: Of `new_model`.
        pixels: (n, 3, h, w), normalised; whole pictures, or windows of them.
        corners: (n, 2) row and column, in patches, of where each window lies in its picture; None
            for whole pictures.
    """
    tower = model.clip.vision_model
    embeddings = tower.embeddings
    patches = embeddings.patch_embedding(pixels)  # (n, width, rows, columns)
    count, width, rows, columns = patches.shape
    side = math.isqrt(embeddings.num_patches)
    if corners is None:
        corners = torch.zeros(count, 2, dtype=torch.long)
    row = corners[:, 0, None, None] + torch.arange(rows)[None, :, None]
    column = corners[:, 1, None, None] + torch.arange(columns)[None, None, :]
    places = 1 + (row * side + column).flatten(1)  # (n, patches); 0 is the class token's
    tokens = patches.flatten(2).transpose(1, 2) + embeddings.position_embedding(places)
    first = embeddings.class_embedding + embeddings.position_embedding.weight[0]
    hidden = torch.cat([first.expand(count, 1, width), tokens], dim=1)
    hidden = tower.pre_layrnorm(hidden)
    kept: dict[int, torch.Tensor] = {}
    for number, layer in enumerate(tower.encoder.layers):
        hidden = layer(hidden, attention_mask=None)
        kept[number] = hidden
    return tuple(kept[number] for number in model.extract_layers)


def decode(
    model: Any,
    activations: tuple[torch.Tensor, ...],
    conditions: torch.Tensor,
    part: tuple[int, int] = (0, 0),
    step: int = 1,
    loudness: list[torch.Tensor] | None = None,
) -> torch.Tensor:
    """Return the logits (phrases, h / step, w / step) of phrases, with gradients.

    What the model's own decoder computes, with two savings: a picture's activations are reduced
    once for all of its phrases, and only every `step`-th row and column of the heatmap is made.

    Args:
        model: Of `new_model`.
        activations: Of `features`, each (n, 1 + patches, width).
        conditions: (phrases, projection): those of the first picture, then those of the second
            ..., equally many of each.
        part: The first row and column of the heatmap that is made.
        step: From one row to the next that is made.
        loudness: Takes the mean square of what enters each layer.
    """
    decoder = model.decoder
    each = len(conditions) // len(activations[0])
    output: torch.Tensor | None = None
    reversed_layers = zip(activations[::-1], decoder.layers, decoder.reduces, strict=True)
    for number, (activation, layer, reduce) in enumerate(reversed_layers):
        reduced = reduce(activation).repeat_interleave(each, dim=0)
        output = reduced if output is None else reduced + output
        if number == decoder.conditional_layer:
            scale, shift = decoder.film_mul(conditions), decoder.film_add(conditions)
            output = scale[:, None] * output + shift[:, None]
        if loudness is not None:
            loudness.append(output.detach().float().square().mean())
        output = layer(output, attention_mask=None)
    if output is None:
        raise ValueError("a decoder without layers")
    side = math.isqrt(output.shape[1] - 1)
    grid = output[:, 1:].transpose(1, 2).reshape(len(output), -1, side, side)
    last = decoder.transposed_convolution
    weight = last.weight[:, :, part[0] :: step, part[1] :: step]
    logits = torch.nn.functional.conv_transpose2d(
        grid, weight, last.bias, stride=last.stride[0] // step
    )
    return logits.squeeze(1)


def quieten(model: Any, loudness: Sequence[float]) -> None:
    """Scale down what entered layers of the decoder louder than `LOUDEST`, at its weights.

    The layers of the decoder normalise what they put out, never what they take: the size of their
    input changes little but how sharp their attention is. Left alone it grows without end, and
    attention between tokens of several hundred has gradients that overflow.

    Args:
        model: Of `new_model`.
        loudness: Of `decode`, of the last step.
    """
    decoder = model.decoder
    with torch.no_grad():
        for number, loud in enumerate(loudness):
            if loud > LOUDEST:
                conditional = number == decoder.conditional_layer
                makers = (
                    (decoder.film_mul, decoder.film_add)
                    if conditional
                    else (decoder.reduces[number],)
                )
                for maker in makers:
                    maker.weight.mul_(math.sqrt(LOUDEST / loud))
                    maker.bias.mul_(math.sqrt(LOUDEST / loud))


def embed(model: Any, tokens: Any) -> torch.Tensor:
    """Return the embeddings (phrases, projection) of tokenized phrases, with gradients."""
    output = model.clip.get_text_features(
        input_ids=tokens["input_ids"], attention_mask=tokens["attention_mask"]
    )
    return torch.as_tensor(output.pooler_output)


def save(model: Any, processor: Any, card: ModelCard, directory: Path) -> None:
    """Write a checkpoint directory, with weights in half precision."""
    from transformers import CLIPSegForImageSegmentation

    directory.mkdir(parents=True, exist_ok=True)
    half: Any = CLIPSegForImageSegmentation(model.config)
    half.load_state_dict(model.state_dict())
    half.half().save_pretrained(directory)
    # safetensors makes its file readable by its owner only.
    (directory / "model.safetensors").chmod(0o644)
    processor.save_pretrained(directory)
    write_card(card, directory)


def read(directory: Path) -> tuple[Any, Any, Size]:
    """Return model, processor and size of a checkpoint directory of `save`.

    Raises:
        ConfigError: it was not made by this command.
    """
    from transformers import CLIPSegForImageSegmentation, CLIPSegProcessor

    try:
        processor = CLIPSegProcessor.from_pretrained(directory, backend="pil")
        model: Any = CLIPSegForImageSegmentation.from_pretrained(directory, dtype=torch.float32)
    # transformers, safetensors and the tokenizer each have errors of their own.
    except Exception as error:
        raise ConfigError(f"--from {directory} cannot be read: {error}") from error
    config, vision, text = model.config, model.config.vision_config, model.config.text_config
    if config.use_complex_transposed_convolution:
        raise ConfigError(
            f"--from {directory} has the decoder of `rd64-refined`, which this command does not "
            "train; begin with a checkpoint that it wrote"
        )
    size = Size(
        image=vision.image_size,
        patch=vision.patch_size,
        width=vision.hidden_size,
        layers=vision.num_hidden_layers,
        heads=vision.num_attention_heads,
        extract=tuple(config.extract_layers),
        text_width=text.hidden_size,
        text_layers=text.num_hidden_layers,
        projection=config.projection_dim,
        reduced=config.reduce_dim,
        longest_phrase=text.max_position_embeddings,
    )
    return model, processor, size
