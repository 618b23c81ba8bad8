"""A checkpoint directory with random weights, small enough to make in a test."""

from pathlib import Path

import pytest
import torch

from w2c_grounding.card import ModelCard
from w2c_grounding.train.model import Size, new_model, new_processor, save

TINY = Size(
    image=64,
    patch=16,
    width=32,
    layers=2,
    heads=2,
    extract=(0, 1),
    text_width=32,
    text_layers=1,
    projection=16,
    reduced=16,
)
WORDS = ["the", "red", "blue", "book", "cup"]


@pytest.fixture(scope="session")
def tiny_checkpoint(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a checkpoint directory of this project's own layout; its answers mean nothing."""
    directory = tmp_path_factory.mktemp("checkpoint")
    torch.manual_seed(3)
    processor = new_processor(TINY, WORDS)
    model = new_model(TINY, len(processor.tokenizer))
    card = ModelCard(name="tiny", threshold=0.01, vocabulary=["book", "cup", "red", "blue"])
    save(model, processor, card, directory)
    return directory
