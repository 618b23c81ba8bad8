"""Dropout leaves out a share while the network trains, and nothing when it answers."""

import pytest
import torch
from transformers import Qwen2ForCausalLM

from w2c_llm.train.dropout import Dropout
from w2c_llm.train.network import NetworkSize, make_network

TOKENS = torch.arange(12).reshape(2, 6)


def network() -> Qwen2ForCausalLM:
    made = make_network(NetworkSize(width=64, layers=2, heads=2, feed_forward=64), 300, seed=1)
    made.train()
    return made


def answer(asked: Qwen2ForCausalLM) -> torch.Tensor:
    with torch.no_grad():
        logits: torch.Tensor = asked(TOKENS).logits
    return logits


def test_a_step_draws_the_same_masks_again_and_another_step_others() -> None:
    asked = network()
    dropout = Dropout(asked, 0.3, seed=4)
    found = []
    for step in (1, 2, 1):
        dropout.begin_step(step, len(TOKENS))
        found.append(answer(asked))

    assert torch.equal(found[0], found[2])
    assert not torch.equal(found[0], found[1])


def test_another_seed_draws_other_masks() -> None:
    found = []
    for seed in (1, 2):
        asked = network()
        Dropout(asked, 0.3, seed).begin_step(5, len(TOKENS))
        found.append(answer(asked))

    assert not torch.equal(*found)


def test_nothing_is_left_out_of_an_answer_nor_at_a_share_of_nothing() -> None:
    plain = answer(network())
    answering = network()
    Dropout(answering, 0.3, seed=4)
    answering.train(False)
    without = network()
    Dropout(without, 0.0, seed=4).begin_step(1, len(TOKENS))

    assert torch.equal(answer(answering), plain)
    assert torch.equal(answer(without), plain)


def test_what_a_block_adds_keeps_its_mean_and_loses_its_share() -> None:
    asked = network()
    seen: list[torch.Tensor] = []
    dropout = Dropout(asked, 0.25, seed=4)
    asked.model.layers[0].mlp.register_forward_hook(lambda _, __, output: seen.append(output))
    asked.model.layers[0].mlp.down_proj.register_forward_hook(
        lambda _, __, output: torch.ones_like(output)
    )
    with torch.no_grad():
        for step in range(40):
            dropout.begin_step(step, len(TOKENS))
            asked(TOKENS)
    drawn = torch.cat([output.flatten() for output in seen])

    assert sorted(set(drawn.tolist())) == pytest.approx([0.0, 1 / 0.75])
    assert float((drawn == 0).float().mean()) == pytest.approx(0.25, abs=0.02)
    assert float(drawn.mean()) == pytest.approx(1.0, abs=0.03)


def test_a_channel_is_left_out_of_a_whole_sentence_and_each_sentence_loses_others() -> None:
    asked = network()
    seen: list[torch.Tensor] = []
    Dropout(asked, 0.5, seed=4).begin_step(1, len(TOKENS))
    asked.model.layers[0].mlp.register_forward_hook(lambda _, __, output: seen.append(output))
    answer(asked)
    (left_out,) = (output == 0.0 for output in seen)

    assert torch.equal(left_out, left_out[:, :1].expand_as(left_out))
    assert not torch.equal(left_out[0], left_out[1])
