"""The second look is trained on things cut out of pictures: what is cut, asked and learned."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from fakes.additions import changed_by_a_step, have_the_same_weights, trained_in_parts, without
from fakes.rendered import write_pictures
from w2c.clock import StepClock
from w2c.errors import ConfigError, ModelError
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import load
from w2c_grounding.second_look import crops, weights
from w2c_grounding.second_look.network import SecondLookNetwork
from w2c_grounding.sizes import SIZE_WORDS
from w2c_grounding.train.addition.run import Task, add
from w2c_grounding.train.data import truth_files
from w2c_grounding.train.plan import Plan
from w2c_grounding.train.second_look import batches
from w2c_grounding.train.second_look.batches import SquareBatches
from w2c_grounding.train.second_look.commands import train
from w2c_grounding.train.second_look.loss import match_loss
from w2c_grounding.train.second_look.run import SecondLookAddition
from w2c_grounding.train.second_look.squares import ELSEWHERE, MARGIN, SIDE, Squares, cut_out
from w2c_grounding.train.second_look.trainer import SecondLookTrainer
from w2c_grounding.train.vocabulary import vocabulary_of


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("scenes")
    write_pictures(directory, 30)
    return directory


@pytest.fixture(scope="module")
def squares(data: Path) -> Squares:
    return cut_out(truth_files(data), seed=1)


@pytest.fixture(autouse=True, scope="module")
def few_pictures_a_step() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batches, "BY_CHANCE", 2)
        patch.setattr(batches, "OF_A_GROUP", 2)
        yield


def test_every_thing_is_cut_out_and_some_places_without_one(squares: Squares) -> None:
    assert squares.pixels.shape == (30 * (2 + ELSEWHERE), SIDE, SIDE, 3)
    assert len(squares.cuts) == len(squares.pixels)
    assert [number for mine in squares.of_picture for number in mine] == list(
        range(len(squares.cuts))
    )
    middle = squares.pixels[:, SIDE // 2, SIDE // 2].astype(int)
    for cut, colour in zip(squares.cuts, middle, strict=True):
        if cut.item is not None:
            assert {"red": 0, "green": 1, "blue": 2}[cut.item.colour] == int(colour.argmax())


def test_a_place_says_what_shows_in_it(squares: Squares) -> None:
    places = [cut.inside for cut in squares.cuts if cut.item is None]
    assert any(places)
    assert not all(places)


def test_questions_of_a_step_are_answered_by_the_truth(squares: Squares) -> None:
    network = SecondLookNetwork(vocabulary_of(squares.truths))
    batch = SquareBatches(squares, network, seed=3).make(0)
    assert batch.squares.shape[1:] == (3, crops.SIDE, crops.SIDE)
    assert 0.0 <= float(batch.squares.min()) <= float(batch.squares.max()) <= 1.0
    assert 0.0 < float(batch.fits.mean()) < 1.0
    for (square, phrase), fits in zip(batch.pairs.tolist(), batch.fits.tolist(), strict=True):
        cut = squares.cuts[batch.numbers[square]]
        bare = batch.phrases[phrase]
        for word in ("the ", "a ", "my ", "that "):
            bare = bare.removeprefix(word)
        if cut.item is None:
            assert not fits
        elif bare in cut.item.phrases:
            assert fits
        assert not SIZE_WORDS.intersection(bare.split())


def test_a_step_is_a_function_of_seed_and_number(squares: Squares) -> None:
    network = SecondLookNetwork(vocabulary_of(squares.truths))
    first, again = (SquareBatches(squares, network, seed=3).make(7) for _ in range(2))
    assert first.phrases == again.phrases
    assert torch.equal(first.squares, again.squares)
    assert not torch.equal(SquareBatches(squares, network, seed=3).make(8).squares, first.squares)


def test_the_loss_is_least_where_all_is_right_and_counts_what_is_chosen() -> None:
    fits = torch.tensor([1.0, 0.0, 0.0, 0.0])
    phrases = torch.tensor([0, 0, 1, 1])

    def loss(*logits: float) -> float:
        return float(match_loss(torch.tensor(logits), fits, phrases, 2))

    assert loss(9.0, -9.0, -9.0, -9.0) < 1e-3
    assert loss(9.0, -9.0, 9.0, -9.0) > 1.0  # a phrase that fits nothing
    # Of two that are both said to be it, the other one is chosen.
    assert loss(3.0, 4.0, -9.0, -9.0) > loss(4.0, 3.0, -9.0, -9.0)


@pytest.mark.parametrize("size", [0.0, 1e3, 1e5])
def test_gradients_are_finite(size: float) -> None:
    logits = torch.tensor([size, -size, size], requires_grad=True)
    match_loss(logits, torch.tensor([0.0, 1.0, 0.0]), torch.tensor([0, 0, 1]), 2).backward()  # type: ignore[no-untyped-call]
    assert logits.grad is not None
    assert torch.isfinite(logits.grad).all()


def test_colours_and_shapes_are_learned_and_told_apart(squares: Squares, data: Path) -> None:
    torch.manual_seed(0)
    network = SecondLookNetwork(vocabulary_of(squares.truths))
    plan = Plan(steps=100, rate=3e-3, warm_up=5)
    trainer = SecondLookTrainer(network, squares, plan, StepClock(), 0)
    assert trainer.run(lambda: None, lambda _: None)
    network.eval()
    fresh = cut_out(write_pictures(data / "fresh", 12, first=500), seed=1)
    things = [n for n, cut in enumerate(fresh.cuts) if cut.item is not None]
    images = torch.from_numpy(fresh.pixels[things]).permute(0, 3, 1, 2).float() / 255.0
    rim = round(0.5 * SIDE * (MARGIN - crops.MARGIN) / (1.0 + MARGIN))
    inner = torch.nn.functional.interpolate(
        images[:, :, rim : SIDE - rim, rim : SIDE - rim], size=crops.SIDE
    )
    right = []
    with torch.inference_mode():
        seen = network.see(inner)
        for phrase in ("red thing", "blue thing", "green thing"):
            logits = network.match(seen, network.read(*network.tokens([phrase])))
            for number, logit in zip(things, logits.tolist(), strict=True):
                item = fresh.cuts[number].item
                assert item is not None
                right.append((logit > 0.0) == (item.colour == phrase.split()[0]))
    assert np.mean(right) > 0.9


@pytest.fixture(scope="module")
def task(data: Path, tiny_checkpoint: Path, tmp_path_factory: pytest.TempPathFactory) -> Task:
    out = tmp_path_factory.mktemp("looking")
    return Task(data=data, checkpoint=tiny_checkpoint, out=out, steps=3, threads=1)


@pytest.fixture(scope="module")
def trained(task: Task) -> dict[str, float]:
    scores = add(SecondLookAddition, task, StepClock(), lambda _: None)
    assert scores is not None
    return scores


def test_a_training_adds_a_second_look_to_a_checkpoint(
    task: Task, trained: dict[str, float]
) -> None:
    family, card = load(ModelConfig(model=str(task.out / "checkpoint"), threads=1))
    assert card.second_look
    assert json.loads((task.out / "scores.json").read_text())["threshold"] == card.threshold
    assert trained["steps"] == 3
    image = np.zeros((90, 160, 3), dtype=np.uint8)
    assert len(family.query(family.prepare(image), ["square", "the red disc"])) == 2


def test_a_checkpoint_whose_second_look_is_missing_is_refused(
    task: Task, trained: dict[str, float], tmp_path: Path
) -> None:
    copy = without(weights.FILE, task.out / "checkpoint", tmp_path)
    with pytest.raises(ModelError, match="w2c train second-look"):
        load(ModelConfig(model=str(copy), threads=1))


def test_an_interrupted_training_ends_with_the_same_weights(
    task: Task, trained: dict[str, float], tmp_path: Path
) -> None:
    parted = trained_in_parts(SecondLookAddition, task, tmp_path)
    assert have_the_same_weights(weights.read, task.out, parted.out)
    with pytest.raises(ConfigError, match="seed was 0, now 4"):
        add(SecondLookAddition, replace(parted, seed=4), StepClock(), lambda _: None)


def test_a_second_look_that_is_there_is_gone_on_from(
    task: Task, trained: dict[str, float], tmp_path: Path
) -> None:
    named = replace(task, name="more")
    change = changed_by_a_step(SecondLookAddition, named, tmp_path, weights.read, "summary.weight")
    assert 0.0 < change < 0.02
    assert load(ModelConfig(model=str(tmp_path / "checkpoint"), threads=1))[1].name == "more"


def test_gradients_that_are_no_numbers_end_a_training_with_advice(
    task: Task, tmp_path: Path
) -> None:
    with pytest.raises(ModelError, match="lower --rate"):
        add(SecondLookAddition, replace(task, out=tmp_path, rate=1e30), StepClock(), lambda _: None)
    assert not (tmp_path / "checkpoint").exists()


def test_the_command_says_what_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flags = ["--data", str(tmp_path), "--out", str(tmp_path), "--checkpoint", str(tmp_path)]
    assert train(flags) != 0
    assert "w2c scenes render" in capsys.readouterr().err
