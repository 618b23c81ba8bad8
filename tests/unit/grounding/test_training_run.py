"""Very short trainings: interrupted, continued, repeated, scored."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from msgspec import structs

from fakes.rendered import write_pictures
from fakes.tiny_models import TINY
from w2c.clock import StepClock
from w2c.errors import ConfigError, ModelError
from w2c_grounding.card import read_card, write_card
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import load
from w2c_grounding.things import weights as things_weights
from w2c_grounding.things.network import ThingsNetwork
from w2c_grounding.train.commands import train
from w2c_grounding.train.model import read
from w2c_grounding.train.plan import Plan
from w2c_grounding.train.run import Run, Task
from w2c_grounding.train.score import Trial, calibrate, score_model, summarise

PLAN = Plan(windows=4, window_cells=2, warm_up=2)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("scenes")
    write_pictures(directory, 24)
    return directory


@pytest.fixture(scope="module")
def task(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Task:
    out = tmp_path_factory.mktemp("trained")
    return Task(data=data, out=out, steps=6, threads=1, size=TINY, plan=PLAN)


class After:
    """Asks for the end after so many steps."""

    def __init__(self, steps: int) -> None:
        self._left = steps

    def __call__(self) -> bool:
        self._left -= 1
        return self._left < 0


def weights(task: Task) -> dict[str, torch.Tensor]:
    state: dict[str, dict[str, torch.Tensor]] = torch.load(task.out / "state.pt", weights_only=True)
    return state["average"]


@pytest.fixture(scope="module")
def trained(task: Task) -> dict[str, float]:
    scores = Run(task, StepClock(), lambda _: None)()
    assert scores is not None
    return scores


def test_a_training_leaves_a_checkpoint_that_loads_and_its_scores(
    task: Task, trained: dict[str, float]
) -> None:
    family, card = load(ModelConfig(model=str(task.out / "checkpoint"), threads=1))
    assert card.vocabulary is not None
    assert {"square", "red"} <= set(card.vocabulary)
    assert card.names_of_size == ("big button",)
    image = np.zeros((90, 160, 3), dtype=np.uint8)
    assert len(family.query(family.prepare(image), ["square", "disc"])) == 2
    assert json.loads((task.out / "scores.json").read_text())["threshold"] == card.threshold
    assert trained["steps"] == 6
    assert 0.0 <= trained["hit"] <= 1.0


def test_an_interrupted_training_ends_with_the_same_weights(
    task: Task, trained: dict[str, float], tmp_path: Path
) -> None:
    parted = replace(task, out=tmp_path)
    assert Run(parted, StepClock(), lambda _: None)(After(2)) is None
    assert not (tmp_path / "checkpoint").exists()
    assert Run(replace(parted, resume=True), StepClock(), lambda _: None)() is not None
    straight, resumed = weights(task), weights(parted)
    assert all(torch.equal(straight[name], resumed[name]) for name in straight)


def test_weights_can_be_begun_with(task: Task, trained: dict[str, float], tmp_path: Path) -> None:
    begun = replace(task, out=tmp_path, begin_with=task.out / "checkpoint", steps=1)
    assert Run(begun, StepClock(), lambda _: None)() is not None
    before, after = weights(task), weights(begun)
    change = max(float((before[name] - after[name]).abs().max()) for name in before)
    assert 0.0 < change < 0.02


def test_of_words_alone_what_sees_pictures_learns_nothing(
    task: Task, trained: dict[str, float], tmp_path: Path
) -> None:
    begun = replace(
        task, out=tmp_path, begin_with=task.out / "checkpoint", steps=2, words_only=True
    )
    assert Run(begun, StepClock(), lambda _: None)() is not None
    before, after = read(task.out / "checkpoint")[0].state_dict(), weights(begun)
    changed = {name for name in before if not torch.equal(before[name], after[name])}
    assert not any("vision_model" in name for name in changed)
    assert any("text_model" in name for name in changed)
    assert any(name.startswith("decoder") for name in changed)


@pytest.mark.parametrize(
    ("words_only", "side", "kept"), [(True, None, True), (False, None, False), (True, 64, False)]
)
def test_what_finds_things_is_kept_as_long_as_what_sees_pictures(
    *,
    words_only: bool,
    side: int | None,
    kept: bool,
    task: Task,
    trained: dict[str, float],
    tmp_path: Path,
) -> None:
    before = shutil.copytree(task.out / "checkpoint", tmp_path / "before")
    things_weights.write(ThingsNetwork(2 * TINY.width), before)
    begun = replace(
        task, out=tmp_path, begin_with=before, steps=1, words_only=words_only, side=side
    )
    assert Run(begun, StepClock(), lambda _: None)() is not None
    assert read_card(tmp_path / "checkpoint", "").things == kept
    assert (tmp_path / "checkpoint" / things_weights.FILE).is_file() == kept


def test_words_alone_need_a_checkpoint_that_sees(task: Task, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="--from"):
        Run(replace(task, out=tmp_path, words_only=True), StepClock(), lambda _: None)()


def test_what_was_known_before_stays_known(
    task: Task, trained: dict[str, float], tmp_path: Path
) -> None:
    before = shutil.copytree(task.out / "checkpoint", tmp_path / "before")
    card = structs.replace(
        read_card(before, ""), vocabulary=["gate"], names_of_size=("little gate",)
    )
    write_card(card, before)
    begun = replace(task, out=tmp_path, begin_with=before, steps=1)
    assert Run(begun, StepClock(), lambda _: None)() is not None
    after = read_card(tmp_path / "checkpoint", "")
    assert {"gate", "square"} <= set(after.vocabulary or ())
    assert after.names_of_size == ("big button", "little gate")


def test_another_training_is_not_continued(task: Task, trained: dict[str, float]) -> None:
    other = replace(task, resume=True, seed=5)
    with pytest.raises(ConfigError, match="seed was 0, now 5"):
        Run(other, StepClock(), lambda _: None)()


def test_a_state_that_is_none_is_refused(task: Task, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="without --resume"):
        Run(replace(task, out=tmp_path, resume=True), StepClock(), lambda _: None)()


def test_gradients_that_are_no_numbers_end_a_training(task: Task, tmp_path: Path) -> None:
    wild = replace(task, out=tmp_path, steps=60, rate=1e30)
    with pytest.raises(ModelError, match="--rate"):
        Run(wild, StepClock(), lambda _: None)()


def test_the_command_says_what_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert train(["--data", str(tmp_path / "none"), "--out", str(tmp_path / "out")]) == 2
    assert "w2c scenes render" in capsys.readouterr().err


def test_a_checkpoint_is_scored_on_any_pictures(
    task: Task, trained: dict[str, float], tmp_path: Path
) -> None:
    write_pictures(tmp_path, 3, first=900000)
    trials, threshold, name = score_model(str(task.out / "checkpoint"), tmp_path, threads=1)
    assert name == task.name
    kinds = {trial.phrase_kind for trial in trials if trial.kind}
    assert {"name", "synonym", "colour"} <= kinds
    scores = summarise(trials, threshold)
    assert scores["absent_rejected"][1] == 18
    assert scores["hit"][1] == sum(1 for trial in trials if trial.kind)


def trial(score: float, kind: str = "", *, hits: bool = False, unseen: bool = False) -> Trial:
    return Trial("x", "name", kind, unseen, False, score, hits, hits, 0.0)


def test_the_threshold_turns_down_the_wanted_share_of_absent_phrases() -> None:
    absent = [trial(score) for score in np.linspace(0.1, 0.6, 101)]
    present = [trial(0.9, "book", hits=True), trial(0.01, "book", hits=True)]
    threshold = calibrate([*absent, *present], 0.9)
    scores = summarise([*absent, *present, trial(0.9, "hat", unseen=True)], threshold)
    assert scores["absent_rejected"][0] == pytest.approx(0.9, abs=0.02)
    assert scores["hit"] == (1.0, 2)
    assert scores["found_and_hit"] == (0.5, 2)
    assert scores["hit.kind.book"] == (1.0, 2)
    assert scores["hit.unseen_kind"] == (0.0, 1)
    assert "hit.kind.hat" not in scores


def test_calibration_without_absent_phrases_is_refused() -> None:
    with pytest.raises(ConfigError, match="no absent phrase"):
        calibrate([trial(0.9, "book")])
