"""The network of things is learned from which pixels belong to which thing."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from fakes.additions import changed_by_a_step, have_the_same_weights, trained_in_parts, without
from fakes.rendered import write_pictures
from fakes.tiny_models import TINY
from w2c.clock import StepClock
from w2c.errors import ConfigError, ModelError
from w2c_grounding.clipseg import ClipSeg
from w2c_grounding.guard import Guarded
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import load
from w2c_grounding.second_look import weights as second_look_weights
from w2c_grounding.second_look.looks_again import LooksAgain, SeenThings
from w2c_grounding.second_look.network import SecondLookNetwork
from w2c_grounding.things import weights
from w2c_grounding.things.finder import ThingFinder
from w2c_grounding.things.network import ThingsNetwork
from w2c_grounding.train.addition.run import Task, add
from w2c_grounding.train.data import ROBOT, ObjectTruth, PictureTruth, truth_files
from w2c_grounding.train.model import read
from w2c_grounding.train.pictures import open_pictures
from w2c_grounding.train.plan import Plan
from w2c_grounding.train.things import trainer
from w2c_grounding.train.things.commands import train
from w2c_grounding.train.things.loss import overlaps, things_loss
from w2c_grounding.train.things.recall import recall
from w2c_grounding.train.things.run import ThingsAddition, as_it_sees
from w2c_grounding.train.things.targets import targets_of
from w2c_grounding.train.things.trainer import ThingsTrainer

SIDE, ROWS = 64, 8


def truth(*kinds: str) -> PictureTruth:
    things = tuple(
        ObjectTruth(
            id=number, kind=kind, colour="", names=(kind,), phrases=(kind,), visible_pixels=100
        )
        for number, kind in enumerate(kinds, start=1)
    )
    return PictureTruth(image="", identity="", width=SIDE, height=SIDE, seed=0, objects=things)


def owned(*areas: tuple[int, slice, slice]) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    owners = np.zeros((1, SIDE, SIDE), np.uint8)
    for identity, rows, columns in areas:
        owners[0, rows, columns] = identity
    return owners


def test_a_place_wants_the_box_of_what_is_seen_there() -> None:
    owners = owned((1, slice(8, 40), slice(8, 32)), (2, slice(24, 56), slice(24, 60)))
    wanted = targets_of(owners, [truth("mug", "book")], ROWS)
    assert wanted.things[0, 1, 1] == 1.0
    assert wanted.things[0, 0, 0] == 0.0
    # What lies behind ends where it is last seen.
    assert wanted.boxes[0, 1, 1].tolist() == pytest.approx([8 / 64, 8 / 64, 32 / 64, 40 / 64])
    assert wanted.boxes[0, 4, 4].tolist() == pytest.approx([24 / 64, 24 / 64, 60 / 64, 56 / 64])
    for inside in (wanted.boxes[0, ..., 0] == 8 / 64, wanted.boxes[0, ..., 0] == 24 / 64):
        assert float(wanted.weights[0][inside].sum()) == pytest.approx(1.0)


def test_furniture_and_the_robot_are_no_things() -> None:
    owners = owned((1, slice(0, 64), slice(0, 30)), (ROBOT, slice(0, 64), slice(40, 64)))
    wanted = targets_of(owners, [truth("table")], ROWS)
    assert not wanted.things.any()
    assert not wanted.weights.any()


def test_of_what_next_to_nothing_shows_nothing_is_wanted() -> None:
    wanted = targets_of(owned((1, slice(4, 5), slice(4, 5))), [truth("mug")], ROWS)
    assert wanted.things[0, 0, 0] == -1.0
    assert not wanted.weights.any()


def corners(*values: float) -> torch.Tensor:
    return torch.tensor([list(values)])


@given(
    st.lists(st.floats(0.0, 1.0, width=32), min_size=8, max_size=8),
)
def test_overlaps_are_symmetric_and_bounded(ends: list[float]) -> None:
    first, second = (
        corners(*sorted(ends[n : n + 2]), *sorted(ends[n + 2 : n + 4]))[:, [0, 2, 1, 3]]
        for n in (0, 4)
    )
    overlap, generalised = (float(one) for one in overlaps(first, second))
    again, generalised_again = (float(one) for one in overlaps(second, first))
    assert overlap == pytest.approx(again, abs=1e-5)
    assert generalised == pytest.approx(generalised_again, abs=1e-4)
    assert -1e-5 <= overlap <= 1.0 + 1e-5
    assert -1.0 - 1e-4 <= generalised <= overlap + 1e-5


def test_overlaps_of_boxes_that_are_known() -> None:
    whole = corners(0.0, 0.0, 1.0, 1.0)
    assert [float(one) for one in overlaps(whole, whole)] == pytest.approx([1.0, 1.0])
    left, right = corners(0.0, 0.0, 0.25, 1.0), corners(0.5, 0.0, 0.75, 1.0)
    # A third of what is around both is of neither.
    assert [float(one) for one in overlaps(left, right)] == pytest.approx([0.0, -1.0 / 3.0])


def test_the_loss_is_least_for_what_is_wanted() -> None:
    wanted = targets_of(owned((1, slice(8, 40), slice(8, 32))), [truth("mug")], ROWS)
    sure = torch.where(wanted.things > 0.0, 9.0, -9.0)
    right = float(things_loss(sure, sure, wanted.boxes, wanted))
    assert right < 0.01
    assert float(things_loss(-sure, sure, wanted.boxes, wanted)) > right + 1.0
    assert float(things_loss(sure, -sure, wanted.boxes, wanted)) > right + 1.0
    moved = wanted.boxes + torch.tensor([0.1, 0.0, 0.1, 0.0])
    assert float(things_loss(sure, sure, moved, wanted)) > right + 0.3
    nothing = targets_of(owned(), [truth()], ROWS)
    assert float(things_loss(-torch.ones(1, 8, 8) * 9, sure, wanted.boxes, nothing)) < 0.01


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("scenes")
    write_pictures(directory, 60)
    return directory


def test_things_are_found_after_a_short_training(
    data: Path, tiny_checkpoint: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trainer, "WINDOWS", 1)
    torch.manual_seed(0)
    model, _, size = read(tiny_checkpoint)
    pictures = open_pictures(truth_files(data), size.image, tmp_path)
    network = ThingsNetwork(2 * TINY.width)
    plan = Plan(steps=50, rate=5e-3, warm_up=5)
    training = ThingsTrainer(network, model, size, pictures, plan, StepClock(), 0)
    before = {name: value.clone() for name, value in model.state_dict().items()}
    assert training.run(lambda: None, lambda _: None)
    fresh = write_pictures(tmp_path / "fresh", 20, first=500)
    seen = as_it_sees(tiny_checkpoint, 1)
    found = recall(seen, ThingFinder(network), fresh)
    assert found["things.found"] > 0.8
    assert found["things.of_a_picture"] < 4.0
    assert recall(seen, ThingFinder(ThingsNetwork(2 * TINY.width)), fresh)["things.found"] < 0.5
    assert all(torch.equal(value, before[name]) for name, value in model.state_dict().items())


@pytest.fixture(scope="module")
def looking(tiny_checkpoint: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the tiny checkpoint with a second look."""
    directory = tmp_path_factory.mktemp("looking")
    for file in tiny_checkpoint.iterdir():
        (directory / file.name).write_bytes(file.read_bytes())
    card = json.loads((directory / "grounding.json").read_text())
    (directory / "grounding.json").write_text(json.dumps({**card, "second_look": True}))
    torch.manual_seed(1)
    second_look_weights.write(SecondLookNetwork(["red", "square", "disc"]), directory)
    return directory


@pytest.fixture(scope="module")
def task(data: Path, looking: Path, tmp_path_factory: pytest.TempPathFactory) -> Task:
    out = tmp_path_factory.mktemp("things")
    return Task(data=data, checkpoint=looking, out=out, steps=3, threads=1)


@pytest.fixture(scope="module")
def trained(task: Task) -> dict[str, float]:
    scores = add(ThingsAddition, task, StepClock(), lambda _: None)
    assert scores is not None
    return scores


def test_a_training_adds_things_to_a_checkpoint(task: Task, trained: dict[str, float]) -> None:
    family, card = load(ModelConfig(model=str(task.out / "checkpoint"), threads=1))
    assert card.things
    assert card.second_look
    written = json.loads((task.out / "scores.json").read_text())
    assert written["things.found"] == trained["things.found"]
    assert trained["steps"] == 3
    assert 0.0 <= trained["things.found"] <= 1.0
    assert isinstance(family, Guarded)
    assert isinstance(family.family, LooksAgain)
    image = np.zeros((90, 160, 3), dtype=np.uint8)
    context = family.prepare(image)
    assert isinstance(context, SeenThings)
    assert len(family.query(context, ["square", "the red disc"])) == 2
    alone = as_it_sees(task.out / "checkpoint", 1)
    assert isinstance(alone, Guarded)
    assert isinstance(alone.family, ClipSeg)


def test_a_checkpoint_whose_things_are_missing_is_refused(
    task: Task, trained: dict[str, float], tmp_path: Path
) -> None:
    copy = without(weights.FILE, task.out / "checkpoint", tmp_path)
    with pytest.raises(ModelError, match="w2c train things"):
        load(ModelConfig(model=str(copy), threads=1))


def test_an_interrupted_training_ends_with_the_same_weights(
    task: Task, trained: dict[str, float], tmp_path: Path
) -> None:
    parted = trained_in_parts(ThingsAddition, task, tmp_path)
    assert have_the_same_weights(weights.read, task.out, parted.out)


def test_things_that_are_found_already_are_gone_on_from(
    task: Task, trained: dict[str, float], tmp_path: Path
) -> None:
    change = changed_by_a_step(ThingsAddition, task, tmp_path, weights.read, "edges.0.weight")
    assert 0.0 < change < 0.02


def test_a_checkpoint_that_looks_once_has_no_use_for_things(
    task: Task, tiny_checkpoint: Path, tmp_path: Path
) -> None:
    once = replace(task, checkpoint=tiny_checkpoint, out=tmp_path)
    with pytest.raises(ConfigError, match="w2c train second-look"):
        add(ThingsAddition, once, StepClock(), lambda _: None)


def test_the_command_says_what_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flags = ["--data", str(tmp_path), "--out", str(tmp_path), "--checkpoint", str(tmp_path)]
    assert train(flags) != 0
    assert "w2c scenes render" in capsys.readouterr().err
