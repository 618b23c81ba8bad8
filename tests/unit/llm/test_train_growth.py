"""A deeper network begins with the answers of the one it grew from, and learns in every layer."""

import pytest
import torch
from transformers import Qwen2ForCausalLM

from w2c.errors import ConfigError
from w2c_llm.train.corpus import Example, Turn
from w2c_llm.train.growth import deepened
from w2c_llm.train.network import NetworkSize, make_network
from w2c_llm.train.optimizer import Optimizer
from w2c_llm.train.origin import Origin
from w2c_llm.train.tokenizer import train_tokenizer

SIZE = NetworkSize(width=64, layers=3, heads=2, feed_forward=64, context=128)
TOKENIZER = train_tokenizer([Example([Turn("user", "say cup now")], "cup")], 300)
TOKENS = torch.arange(12).reshape(2, 6)


def origin() -> Origin:
    return Origin(make_network(SIZE, TOKENIZER.get_vocab_size(), 7), TOKENIZER, SIZE)


def answer(asked: Qwen2ForCausalLM) -> torch.Tensor:
    with torch.no_grad():
        logits: torch.Tensor = asked(TOKENS).logits
    return logits


@pytest.mark.parametrize("layers", [3, 4, 5, 6, 8])
def test_a_deeper_network_answers_as_the_one_it_grew_from(layers: int) -> None:
    before = origin()
    grown = deepened(before, layers)
    assert grown.size.layers == len(grown.network.model.layers) == layers
    assert grown.tokenizer is before.tokenizer
    torch.testing.assert_close(answer(grown.network), answer(before.network))


def test_new_layers_stand_evenly_between_the_old_ones() -> None:
    before = origin()
    grown = deepened(before, 5).network.state_dict()
    known = before.network.state_dict()
    gate, down = "mlp.gate_proj.weight", "mlp.down_proj.weight"
    for index, source in enumerate((0, 0, 1, 1, 2)):
        ours, theirs = f"model.layers.{index}.", f"model.layers.{source}."
        assert torch.equal(grown[ours + gate], known[theirs + gate]), index
        assert bool(grown[ours + down].any()) == (index in (0, 2, 4)), index


def test_every_layer_learns() -> None:
    grown = deepened(origin(), 6).network
    before = {name: weight.clone() for name, weight in grown.named_parameters()}
    optimizer = Optimizer(grown, 0.0)
    for _ in range(2):
        optimizer.clear()
        torch.autograd.backward(grown(TOKENS, labels=TOKENS).loss)
        optimizer.step(1e-2)
    for name, weight in grown.named_parameters():
        if weight.ndim == 2 and ".layers." in name:
            assert not torch.equal(weight, before[name]), name


def test_no_layer_can_be_left_out() -> None:
    with pytest.raises(ConfigError, match="--layers is 2, the network to begin with has 3"):
        deepened(origin(), 2)
