"""A small CLIPSeg from nothing, in the layout that `from_pretrained` reads."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch

from w2c_grounding.card import ModelCard, write_card
from w2c_grounding.train.tokens import make_tokenizer

# Of the ImageNet pictures, as all CLIPSeg checkpoints have them.
MEAN = (0.485, 0.456, 0.406)
DEVIATION = (0.229, 0.224, 0.225)


@dataclass(frozen=True)
class Size:
    """How large the model is. The defaults are those of the embedded one."""

    image: int = 208
    """The picture is squashed to a square of this side [px]: the decoder knows only squares"""
    patch: int = 16
    width: int = 160
    """Of the picture tower"""
    layers: int = 5
    heads: int = 5
    extract: tuple[int, ...] = (1, 4)
    """Layers whose activations the decoder reads"""
    text_width: int = 96
    text_layers: int = 2
    projection: int = 96
    reduced: int = 64
    """Width of the decoder, the `rd64` of the published checkpoints"""
    longest_phrase: int = 24
    """[tokens]"""


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
        decoder_intermediate_size=4 * size.reduced,
        # Its two up-samplings by a quarter of the patch make one of a whole patch only where it
        # is 16.
        use_complex_transposed_convolution=size.patch == 16,
    )
    model = CLIPSegForImageSegmentation(config)
    start_decoder(model)
    start_positions(model, size)
    start_attention(model)
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
    last: Any = decoder.transposed_convolution
    last = last[-1] if isinstance(last, torch.nn.Sequential) else last
    torch.nn.init.constant_(last.bias, -3.0)


def start_positions(model: Any, size: Size) -> None:
    """Start the position embeddings as sines and cosines of row and column.

    They are learned from there. Random ones must first discover which patches are neighbours, which
    a short training cannot afford.
    """
    side = size.image // size.patch
    quarter = size.width // 4
    frequencies = torch.pi * torch.logspace(0.0, 1.0, quarter, base=side / 2.0)
    positions = (torch.arange(side) + 0.5) / side
    angles = positions[:, None] * frequencies[None, :]  # (side, quarter)
    waves = torch.cat([angles.sin(), angles.cos()], dim=1)  # (side, width / 2)
    rows = waves[:, None, :].expand(side, side, -1)
    columns = waves[None, :, :].expand(side, side, -1)
    grid = torch.cat([rows, columns], dim=2).reshape(side * side, -1)
    with torch.no_grad():
        embedding = model.clip.vision_model.embeddings.position_embedding.weight
        embedding[1:, : grid.shape[1]] = 0.5 * grid


def start_attention(model: Any) -> None:
    """Start each head of the picture tower attending to what is like itself, near itself.

    Queries and keys begin as the same projection, after Trockman and Kolter, "Mimetic
    Initialization of Self-Attention Layers", ICML 2023: small towers on few pictures learn much
    faster from there.
    """
    with torch.no_grad():
        for layer in model.clip.vision_model.encoder.layers:
            attention = layer.self_attn
            torch.nn.init.orthogonal_(attention.q_proj.weight, gain=0.7)
            attention.k_proj.weight.copy_(attention.q_proj.weight)


def start_patches(model: Any, pictures: torch.Tensor) -> None:
    """Start the patch embedding at the principal components of patches, scaled to like variance.

    Args:
        model: Of `new_model`.
        pictures: (n, 3, side, side), normalised; a few dozen are enough.
    """
    embedding = model.clip.vision_model.embeddings.patch_embedding
    patch = embedding.kernel_size[0]
    patches = torch.nn.functional.unfold(pictures, patch, stride=patch)  # (n, 3 patch^2, patches)
    flat = patches.transpose(1, 2).reshape(-1, patches.shape[1])
    flat = flat - flat.mean(dim=0)
    values, vectors = torch.linalg.eigh(flat.T @ flat / len(flat))  # ascending
    count = min(embedding.out_channels, vectors.shape[1])
    values, vectors = values[-count:].flip(0), vectors[:, -count:].flip(1)
    # The floor keeps components that are mostly noise from being blown up.
    scale = (values + 0.02 * values[0].sqrt()).clamp(min=1e-6).rsqrt()
    with torch.no_grad():
        embedding.weight[:count] = (vectors * scale).T.reshape(count, *embedding.weight.shape[1:])


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


def features(model: Any, pixels: torch.Tensor) -> tuple[torch.Tensor, ...]:
    """Return the activations (batch, tokens, width) that the decoder reads, with gradients."""
    output = model.clip.get_image_features(pixel_values=pixels, output_hidden_states=True)
    return tuple(output.hidden_states[layer + 1] for layer in model.extract_layers)


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
