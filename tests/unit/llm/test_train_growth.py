"""A deeper network begins with the answers of the one it grew from, and learns in every layer."""

from dataclasses import replace
from pathlib import Path

import pytest
import torch
from transformers import Qwen2ForCausalLM

from w2c.clock import StepClock
from w2c.errors import ConfigError
from w2c_llm.train.batches import mix
from w2c_llm.train.corpus import Example, Turn
from w2c_llm.train.growth import deepened
from w2c_llm.train.loop import Listeners, Progress, Recipe, Report, Trainer, learning_rate
from w2c_llm.train.network import NetworkSize, make_network
from w2c_llm.train.optimizer import Optimizer
from w2c_llm.train.origin import Origin, read_origin
from w2c_llm.train.plan import Shape, TrainingPlan
from w2c_llm.train.run import CHECKPOINT, Run
from w2c_llm.train.tokenizer import encode_all, train_tokenizer

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


def test_the_rate_rises_again_after_a_growth() -> None:
    recipe = Recipe(minutes=1.0, steps=1000)
    progress = Progress(step=400)
    assert progress.rate(recipe) == learning_rate(recipe, 0.4)
    progress.grown_at = 400
    assert progress.rate(recipe) == pytest.approx(0.01 * learning_rate(recipe, 0.4))
    progress.step = 449
    assert progress.rate(recipe) == pytest.approx(0.5 * learning_rate(recipe, 0.449))
    progress.step = 600
    assert progress.rate(recipe) == learning_rate(recipe, 0.6)


def test_a_trainer_of_a_deeper_network_goes_on_where_the_other_was() -> None:
    example = Example([Turn("user", "say cup now")], "cup")
    mixture = mix(list(encode_all(TOKENIZER, [example] * 12)), [], 0.2)
    before = origin()
    small = Trainer(before.network, Recipe(minutes=1.0, steps=9, batch=3), StepClock(), 0)
    reports: list[Report] = []
    listeners = Listeners(reports.append, lambda: None)
    assert small.train(mixture, listeners, until=0.5)
    assert (small.progress.step, small.progress.epoch, small.progress.batch) == (5, 1, 1)
    grown = small.grown(deepened(before, 5).network)
    assert grown.progress == replace(small.progress, grown_at=5)
    assert grown.train(mixture, listeners)
    assert (grown.progress.step, grown.progress.examples) == (9, 27)
    assert small.progress.step == 5, "the smaller one is left as it was"


def plan(folder: Path, **changes: object) -> TrainingPlan:
    corpus = folder / "corpus.jsonl"
    line = '{"messages":[{"role":"user","content":"say WORD"}],"answer":"WORD"}'
    corpus.write_text("\n".join(line.replace("WORD", word) for word in ("cup", "mug", "pen")))
    shape = Shape(layers=3, begin_layers=1, width=64, feed_forward=64, vocabulary=300)
    standard = {"output": folder / "run", "shape": shape, "threads": 1, "steps": 6, "batch": 3}
    return TrainingPlan(corpus=corpus, heldout=corpus, **{**standard, **changes})  # type: ignore[arg-type]  # fields by name


def test_a_run_grows_when_a_third_of_its_budget_is_spent(tmp_path: Path) -> None:
    lines: list[str] = []
    result = Run(plan(tmp_path), lines.append)()
    assert result is not None
    assert read_origin(result.model_path).size.layers == 3
    assert "3 layers from here on" in lines
    card = result.card_path.read_text()
    assert "3 layers, width 64" in card
    assert "1 layers up to step 2" in card
    assert read_origin(tmp_path / "run" / CHECKPOINT).size.layers == 3


@pytest.mark.parametrize(("stop_after", "layers"), [(1, 1), (2, 1), (4, 3)])
def test_a_run_that_is_stopped_before_or_after_it_grew_ends_as_an_uninterrupted_one(
    stop_after: int, layers: int, tmp_path: Path
) -> None:
    assert Run(plan(tmp_path, output=tmp_path / "whole"), print)() is not None
    asked = iter([*range(1, stop_after + 1), *[stop_after] * 9])
    assert Run(plan(tmp_path), print)(lambda: next(asked) >= stop_after) is None
    assert read_origin(tmp_path / "run" / CHECKPOINT).size.layers == layers
    result = Run(plan(tmp_path, resume=True), print)()
    assert result is not None
    assert result.steps == 6
    whole = read_origin(tmp_path / "whole" / CHECKPOINT).network.state_dict()
    for name, weight in read_origin(tmp_path / "run" / CHECKPOINT).network.state_dict().items():
        assert torch.equal(weight, whole[name]), name


def test_a_run_that_grows_is_resumed_as_it_was_begun(tmp_path: Path) -> None:
    assert Run(plan(tmp_path), print)(lambda: True) is None
    for shape, said in (
        (Shape(width=64), "--begin-layers was 1, growing to 3, now not given"),
        (Shape(layers=4, begin_layers=1), "now 1, growing to 4"),
    ):
        with pytest.raises(ConfigError, match=said):
            Run(plan(tmp_path, shape=shape, resume=True), print)()


def test_what_cannot_grow_is_refused(tmp_path: Path) -> None:
    for begin, layers, most in ((4, 3, 2), (3, 3, 2), (0, 3, 2), (8, None, 5)):
        shape = Shape(layers=layers, begin_layers=begin)
        with pytest.raises(
            ConfigError, match=rf"--begin-layers is {begin}; it must be 1 to {most}"
        ):
            Run(plan(tmp_path, shape=shape), print)
    with pytest.raises(ConfigError, match=r"--begin-layers is for random weights; with --from"):
        Run(plan(tmp_path, begin_with=(tmp_path / "model.gguf",)), print)
