"""A checkpoint directory with random weights, small enough to make in a test."""

from pathlib import Path

import pytest
import torch

from fakes.tiny_models import TINY, tiny_clip, tiny_grounding_dino, tiny_owlv2
from w2c_grounding.card import ModelCard
from w2c_grounding.train.model import new_model, new_processor, save

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


@pytest.fixture(scope="session")
def dino_checkpoint(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a GroundingDINO directory; its answers mean nothing."""
    return tiny_grounding_dino(tmp_path_factory.mktemp("dino"))


@pytest.fixture(scope="session")
def owlv2_checkpoint(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an OWLv2 directory; its answers mean nothing."""
    return tiny_owlv2(tmp_path_factory.mktemp("owlv2"))


@pytest.fixture(scope="session")
def clip_checkpoint(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a CLIP directory; its answers mean nothing."""
    return tiny_clip(tmp_path_factory.mktemp("clip"))
