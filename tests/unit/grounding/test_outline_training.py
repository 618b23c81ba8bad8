"""Outlines are learned from what a family lights, and from where those things end."""

import json
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from msgspec import structs

from fakes.additions import changed_by_a_step, have_the_same_weights, trained_in_parts, without
from fakes.rendered import COLOURS, write_pictures
from w2c.clock import StepClock
from w2c.errors import ConfigError, ModelError
from w2c_grounding.card import ModelCard, read_card, write_card
from w2c_grounding.clipseg import ClipSeg
from w2c_grounding.family import Evidence, RgbImage
from w2c_grounding.guard import Guarded
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.outline import weights
from w2c_grounding.outline.draws_outlines import DrawsOutlines
from w2c_grounding.outline.network import LAYERS, SIDE, OutlineNetwork
from w2c_grounding.registry import load
from w2c_grounding.sizes import ComparesSizes
from w2c_grounding.train.addition.run import Task, add
from w2c_grounding.train.data import truth_files
from w2c_grounding.train.outline import run, trainer
from w2c_grounding.train.outline.commands import train
from w2c_grounding.train.outline.run import OutlineAddition
from w2c_grounding.train.outline.samples import STORED, collect, lit
from w2c_grounding.train.outline.trainer import OutlineTrainer, outline_loss
from w2c_grounding.train.plan import Plan

LEAST, EDGE = 0.2, 0.3


class LightsHalf:
    """A family that lights the left half of whatever has a colour that was said, or any."""

    def prepare(self, image: RgbImage) -> RgbImage:
        """Keep the picture."""
        return image

    def query(self, context: RgbImage, phrases: Sequence[str]) -> list[Evidence]:
        """Return half of the things of each phrase."""
        return [Evidence(self._heat(context, phrase)) for phrase in phrases]

    def _heat(self, image: RgbImage, phrase: str) -> np.ndarray[Any, np.dtype[np.float32]]:
        said = [colour for name, colour in COLOURS.items() if name in phrase]
        heat = np.zeros(image.shape[:2], np.float32)
        for half in (np.s_[:, :80], np.s_[:, 80:]):
            away = [
                np.abs(image[half].astype(int) - colour).sum(axis=2)
                for colour in said or COLOURS.values()
            ]
            thing = np.min(away, axis=0) < 90
            columns = np.flatnonzero(thing.any(axis=0))
            if len(columns):
                thing[:, int(columns.mean()) :] = False
            heat[half][thing] = 0.9
        return heat


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("scenes")
    write_pictures(directory, 60)
    return directory


def test_what_is_lit_comes_with_the_thing_that_it_shows(data: Path) -> None:
    shown = [
        one
        for path in truth_files(data)[:10]
        for one in lit(LightsHalf(), path, LEAST, EDGE, np.random.default_rng(0))
    ]
    assert len(shown) >= 20
    for one in shown:
        inside = one.thing[one.region.top : one.region.bottom, one.region.left : one.region.right]
        assert inside[one.region.mask].mean() > 0.9
        assert 0.3 < one.region.mask.sum() / one.thing.sum() < 0.7


def test_what_shows_no_thing_is_left_out(data: Path) -> None:
    class LightsACorner(LightsHalf):
        def _heat(self, image: RgbImage, phrase: str) -> np.ndarray[Any, np.dtype[np.float32]]:
            heat = np.zeros(image.shape[:2], np.float32)
            heat[:4, :4] = 0.9
            return heat

    with pytest.raises(ConfigError, match="lights nothing in 60 pictures"):
        collect(LightsACorner(), truth_files(data), LEAST, EDGE, 0, lambda _: None)


def test_squares_hold_picture_heat_region_and_thing(data: Path) -> None:
    squares = collect(LightsHalf(), truth_files(data)[:5], LEAST, EDGE, 0, lambda _: None)
    assert squares.shape[1:] == (STORED, STORED, LAYERS + 1)
    coloured = np.ptp(squares[..., :3].astype(int), axis=3) > 60
    thing = squares[..., LAYERS] > 127
    # JPEG blurs colours at edges; elsewhere the coloured thing in the middle is where it is said.
    assert (coloured[thing]).mean() > 0.9
    middle = np.s_[:, STORED // 3 : -STORED // 3, STORED // 3 : -STORED // 3]
    assert (coloured[middle] == thing[middle]).mean() > 0.9


def test_the_loss_is_least_for_the_thing_itself() -> None:
    thing = torch.zeros(1, SIDE, SIDE)
    thing[0, 20:40, 20:40] = 1.0
    exact = 20.0 * (thing - 0.5)
    none, everything = torch.full_like(thing, -10.0), torch.full_like(thing, 10.0)
    best = float(outline_loss(exact, thing))
    assert best < 0.01
    assert float(outline_loss(none, thing)) > 0.9
    assert float(outline_loss(everything, thing)) > 0.9


def test_halves_become_wholes(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trainer, "OF_A_STEP", 16)
    torch.manual_seed(0)
    squares = collect(LightsHalf(), truth_files(data), LEAST, EDGE, 0, lambda _: None)
    network = OutlineNetwork()
    training = OutlineTrainer(
        network, squares, Plan(steps=60, rate=4e-3, warm_up=5), StepClock(), 0
    )
    assert training.run(lambda: None, lambda _: None)
    fresh = collect(
        LightsHalf(),
        write_pictures(data / "fresh", 10, first=500),
        LEAST,
        EDGE,
        0,
        lambda _: None,
    )
    cut = (STORED - SIDE) // 2
    inner = torch.from_numpy(fresh[:, cut:-cut, cut:-cut]).permute(0, 3, 1, 2).float() / 255.0
    with torch.inference_mode():
        drawn = network.eval()(inner[:, :LAYERS]) > 0.0
    thing = inner[:, LAYERS] > 0.5
    common = (drawn & thing).sum() / (drawn | thing).sum()
    lit_alone = inner[:, 4] > 0.5
    before = (lit_alone & thing).sum() / (lit_alone | thing).sum()
    assert float(before) < 0.6
    assert float(common) > 0.85


@pytest.fixture(scope="module")
def task(data: Path, tiny_checkpoint: Path, tmp_path_factory: pytest.TempPathFactory) -> Task:
    out = tmp_path_factory.mktemp("outlines")
    return Task(data=data, checkpoint=tiny_checkpoint, out=out, steps=3, threads=1)


@pytest.fixture(autouse=True)
def lights_half(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tiny checkpoint's own answers mean nothing."""

    def loaded(config: ModelConfig, changed: object) -> tuple[LightsHalf, ModelCard]:
        return LightsHalf(), read_card(Path(config.model), "tiny")

    monkeypatch.setattr(run, "load", loaded)


@pytest.fixture(scope="module")
def trained(task: Task) -> dict[str, float]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "load", lambda config, changed: (LightsHalf(), None))
        scores = add(OutlineAddition, task, StepClock(), lambda _: None)
    assert scores is not None
    return scores


def test_a_training_adds_outlines_to_a_checkpoint(task: Task, trained: dict[str, float]) -> None:
    family, card = load(ModelConfig(model=str(task.out / "checkpoint"), threads=1))
    assert card.outlines
    assert isinstance(family, Guarded)
    assert isinstance(family.family, DrawsOutlines)
    assert card.threshold == read_card(task.checkpoint, "").threshold
    assert json.loads((task.out / "scores.json").read_text()) == trained
    assert trained["steps"] == 3
    assert 0.3 < trained["overlap.family"] < 0.7
    assert 0.0 <= trained["overlap.outlines"] <= 1.0
    image = np.zeros((90, 160, 3), dtype=np.uint8)
    assert len(family.query(family.prepare(image), ["square", "the red disc"])) == 2


def test_a_checkpoint_is_asked_without_outlines_and_sizes(
    task: Task, trained: dict[str, float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run, "load", load)
    shutil.copytree(task.out / "checkpoint", tmp_path, dirs_exist_ok=True)
    write_card(structs.replace(read_card(tmp_path, ""), compares_sizes=True), tmp_path)
    whole, _ = load(ModelConfig(model=str(tmp_path), threads=1))
    asked = run.without_outlines(tmp_path, 1)
    assert isinstance(whole, Guarded)
    assert isinstance(asked, Guarded)
    assert isinstance(whole.family, ComparesSizes)
    assert isinstance(whole.family.family, DrawsOutlines)
    assert isinstance(asked.family, ClipSeg)


def test_a_checkpoint_whose_outlines_are_missing_is_refused(
    task: Task, trained: dict[str, float], tmp_path: Path
) -> None:
    copy = without(weights.FILE, task.out / "checkpoint", tmp_path)
    with pytest.raises(ModelError, match="w2c train outline"):
        load(ModelConfig(model=str(copy), threads=1))


def test_an_interrupted_training_ends_with_the_same_weights(
    task: Task, trained: dict[str, float], tmp_path: Path
) -> None:
    parted = trained_in_parts(OutlineAddition, task, tmp_path)
    assert have_the_same_weights(weights.read, task.out, parted.out)
    with pytest.raises(ConfigError, match="seed was 0, now 4"):
        add(OutlineAddition, replace(parted, seed=4), StepClock(), lambda _: None)


def test_outlines_that_are_there_are_gone_on_from(
    task: Task, trained: dict[str, float], tmp_path: Path
) -> None:
    named = replace(task, name="more")
    change = changed_by_a_step(OutlineAddition, named, tmp_path, weights.read, "stem.0.weight")
    assert 0.0 < change < 0.02
    assert read_card(tmp_path / "checkpoint", "").name == "more"


def test_gradients_that_are_no_numbers_end_a_training_with_advice(
    task: Task, tmp_path: Path
) -> None:
    with pytest.raises(ModelError, match="lower --rate"):
        add(OutlineAddition, replace(task, out=tmp_path, rate=1e30), StepClock(), lambda _: None)
    assert not (tmp_path / "checkpoint").exists()


def test_the_command_says_what_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flags = ["--data", str(tmp_path), "--out", str(tmp_path), "--checkpoint", str(tmp_path)]
    assert train(flags) != 0
    assert "w2c scenes render" in capsys.readouterr().err
