"""How the picture tower begins: as a stack of convolutions over patches.

A tower of random weights must first discover which patches are neighbours and that neighbours
matter, which an hour on two cores cannot pay for. Here most heads begin by looking at one neighbour
each, at a fixed offset; values and layers behind them are random, and everything is learned from
there. Such a tower computes what a network of shifts and 1 x 1 convolutions does (Wang et al.,
"When Shift Operation Meets Vision Transformer", AAAI 2022; Zheng et al., "Convolutional
Initialization for Data-Efficient Vision Transformers", 2024). The other heads attend to what is
like themselves (Trockman and Kolter, "Mimetic Initialization of Self-Attention Layers", ICML 2023).

The offsets are made of positions: sines and cosines of row and column lie in dimensions of their
own, the last ones. A turn of these pairs is a shift of the position. At the start nothing writes to
these dimensions, and only the heads with an offset read them: what a patch shows means the same
wherever it lies.
"""

import math
from typing import Any

import torch

from w2c_grounding.train.model import Size

Offset = tuple[int, int]
"""Row and column [patches]"""

# A patch covers 1.8 times as much of the frame in width as in height: the picture was squashed.
OFFSETS: tuple[tuple[Offset, ...], ...] = (
    ((0, 1), (0, -1), (1, 0), (-1, 0)),
    ((1, 1), (1, -1), (-1, 1), (-1, -1)),
    ((0, 1), (0, -1), (2, 0), (-2, 0)),
    ((0, 1), (0, -1), (1, 0), (-1, 0)),
    ((1, 1), (1, -1), (-1, 1), (-1, -1)),
    ((0, 2), (0, -2), (3, 0), (-3, 0)),
)
"""Of the heads of each layer; from the start again where there are more layers"""
FREE_SHARE = 3
"""One head in so many attends to what is like itself, at least one"""
SLOWEST, FASTEST = 0.4, 2.6
"""Frequencies of the positions [rad / patch]: high, so that neighbours differ by much"""
AMPLITUDE = 4.0
"""Of the waves. Louder than what patches show: normalising a token divides both by their common
size, and a plain patch must not be a louder key than one with an edge"""
SHARPNESS = 5.0
"""By how much the logit of the wanted neighbour exceeds that of the next one"""


def wave_count(size: Size) -> int:
    """Return the number of frequencies for each of row and column; a head takes all of them."""
    return size.width // size.heads // 4


def frequencies(size: Size) -> torch.Tensor:
    """Return them [rad / patch], ascending."""
    return torch.logspace(math.log10(SLOWEST), math.log10(FASTEST), wave_count(size))


def start_tower(model: Any, size: Size, pictures: torch.Tensor) -> None:
    """Start patches, positions and attention.

    Args:
        model: Of `new_model`.
        size: Its size.
        pictures: (n, 3, side, side), normalised; a few dozen are enough.
    """
    waves = 4 * wave_count(size)
    start_patches(model, pictures, size.width - waves)
    start_positions(model, size)
    _start_layers(model, size, pictures)


def start_patches(model: Any, pictures: torch.Tensor, count: int) -> None:
    """Start the patch embedding at `count` principal components of patches, of like variance.

    The dimensions after those stay empty.
    """
    embedding = model.clip.vision_model.embeddings.patch_embedding
    patch = embedding.kernel_size[0]
    patches = torch.nn.functional.unfold(pictures, patch, stride=patch)  # (n, 3 patch^2, patches)
    flat = patches.transpose(1, 2).reshape(-1, patches.shape[1])
    flat = flat - flat.mean(dim=0)
    values, vectors = torch.linalg.eigh(flat.T @ flat / len(flat))  # ascending
    count = min(count, vectors.shape[1])
    values, vectors = values[-count:].flip(0), vectors[:, -count:].flip(1)
    # The floor keeps components that are mostly noise from being blown up.
    scale = (values + 0.02 * values[0].sqrt()).clamp(min=1e-6).rsqrt()
    with torch.no_grad():
        embedding.weight.zero_()
        embedding.weight[:count] = (vectors * scale).T.reshape(count, *embedding.weight.shape[1:])


def start_positions(model: Any, size: Size) -> None:
    """Start the position embeddings: waves of row and column in the last dimensions."""
    angles = torch.arange(size.cells)[:, None] * frequencies(size)[None, :]  # (cells, waves)
    waves = AMPLITUDE * torch.cat([angles.sin(), angles.cos()], dim=1)
    rows = waves[:, None].expand(size.cells, size.cells, -1)
    columns = waves[None, :].expand(size.cells, size.cells, -1)
    grid = torch.cat([rows, columns], dim=2).flatten(0, 1)
    with torch.no_grad():
        embedding = model.clip.vision_model.embeddings.position_embedding.weight
        embedding.zero_()
        embedding[1:, -grid.shape[1] :] = grid


def turn(offset: Offset, size: Size) -> torch.Tensor:
    """Return the matrix (waves, waves) that moves the waves of a position by an offset."""
    blocks = []
    for distance in offset:
        cosine = torch.diag((frequencies(size) * distance).cos())
        sine = torch.diag((frequencies(size) * distance).sin())
        blocks.append(torch.cat([torch.cat([cosine, sine], 1), torch.cat([-sine, cosine], 1)], 0))
    row, column = blocks
    empty = torch.zeros_like(row)
    return torch.cat([torch.cat([row, empty], 1), torch.cat([empty, column], 1)], 0)


@torch.no_grad()
def _start_layers(model: Any, size: Size, pictures: torch.Tensor) -> None:
    """Start the layers from the first on: how loud positions are in one depends on those before."""
    tower = model.clip.vision_model
    hidden = tower.pre_layrnorm(tower.embeddings(pictures, interpolate_pos_encoding=False))
    waves = 4 * wave_count(size)
    for number, layer in enumerate(tower.encoder.layers):
        normalised = layer.layer_norm1(hidden)[:, 1:]
        # What patches show enters each layer with a variance of one, positions as they are.
        content = 1.0 / normalised[..., :-waves].square().mean().sqrt().clamp(min=1e-3)
        layer.layer_norm1.weight[:-waves] = content
        layer.layer_norm2.weight[:-waves] = content
        layer.layer_norm2.weight[-waves:] = 0.0
        loudness = 2.0 * float(normalised[..., -waves:].square().mean())
        _start_heads(layer.self_attn, size, OFFSETS[number % len(OFFSETS)], loudness)
        layer.self_attn.v_proj.weight[:, -waves:] = 0.0
        layer.self_attn.out_proj.weight[-waves:] = 0.0
        layer.mlp.fc2.weight[-waves:] = 0.0
        hidden = layer(hidden, attention_mask=None)
    for reduce in model.decoder.reduces:
        reduce.weight[:, -waves:] *= 0.25


def _start_heads(attention: Any, size: Size, offsets: tuple[Offset, ...], loudness: float) -> None:
    """Start queries and keys of a layer; `loudness` is the squared amplitude of its waves."""
    waves, head = 4 * wave_count(size), size.width // size.heads
    queries, keys = attention.q_proj.weight, attention.k_proj.weight
    torch.nn.init.orthogonal_(queries, gain=0.7)
    queries[:, -waves:] = 0.0
    keys.copy_(queries)
    contrast = float((1.0 - frequencies(size).cos()).sum())
    gain = math.sqrt(SHARPNESS * math.sqrt(head) / (contrast * loudness))
    for index in range(size.heads - max(1, size.heads // FREE_SHARE)):
        first = index * head
        keys[first : first + head] = 0.0
        queries[first : first + head] = 0.0
        keys[first : first + waves, -waves:] = gain * torch.eye(waves)
        queries[first : first + waves, -waves:] = gain * turn(offsets[index % len(offsets)], size)
