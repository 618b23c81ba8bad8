"""Success of combinations of models: judged, counted, told apart by step, resumed."""

import json
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from w2c import topics
from w2c.bus import Bus, CallContext, InProcessHub
from w2c.errors import ConfigError, ModelError
from w2c.messages import (
    Box,
    ChooseReply,
    ChooseRequest,
    CompleteReply,
    CompleteRequest,
    GroundingReply,
    GroundingRequest,
    PhraseEvidence,
)
from w2c_evaluation.benchmark.dataset import load
from w2c_evaluation.benchmark.record import NamedThing, Record
from w2c_evaluation.prediction import combinations, commands, paper, trial
from w2c_evaluation.prediction.combinations import Catalogue, ModelSpec
from w2c_evaluation.prediction.commands import PredictionConfig as Config
from w2c_evaluation.prediction.commands import chosen, evaluate
from w2c_evaluation.prediction.judging import accepts, first_error, overlap
from w2c_evaluation.prediction.report import success_table
from w2c_evaluation.prediction.trial import random_rates

CUP = (40.0, 20.0, 60.0, 40.0)
SIZE = (80, 120)
"""Rows and columns of the pictures"""


class Models:
    """Services that hear the last word as the object and see the cup, and count their loads."""

    def __init__(self) -> None:
        self.loaded: list[str] = []
        self.completed = 0
        self.looked = 0
        self.expression = "30"

    @contextmanager
    def service(self, kind: str, spec: ModelSpec) -> Iterator[Bus]:
        self.loaded.append(spec.name)
        if spec.name == "broken":
            raise ModelError("no file at models/broken")
        hub = InProcessHub()
        bus = hub.connect("llm" if kind == "language_service" else "grounding")
        if kind == "language_service":
            bus.serve(topics.COMPLETE, self._complete)
            bus.serve(topics.CHOOSE, self._choose)
        else:
            bus.serve(topics.GROUND, self._ground)
        asking = hub.connect("evaluation")
        yield asking
        asking.close()
        bus.close()

    def _complete(self, request: CompleteRequest, _: CallContext) -> CompleteReply:
        self.completed += 1
        text = request.messages[-1].content
        last = text.split()[-1]
        value: dict[str, Any] = {"x": self.expression, "y": "30"}
        if "is at [" not in text:
            position = "relative" if "left of" in text else "absolute"
            value = {"position": position, "objects": [last]}
        return CompleteReply(
            text="", value=value, model="fake", prompt_tokens=1, reused_tokens=0,
            completion_tokens=1, queue_ms=0.0, prefill_ms=0.0, decode_ms=0.0,
        )  # fmt: skip

    def _choose(self, request: ChooseRequest, _: CallContext) -> ChooseReply:
        chances = dict.fromkeys(request.options, 0.0) | {"prediction": 1.0}
        return ChooseReply(
            option="prediction", probabilities=chances, model="fake", prompt_tokens=1,
            reused_tokens=0, queue_ms=0.0, prefill_ms=0.0,
        )  # fmt: skip

    def _ground(self, request: GroundingRequest, _: CallContext) -> GroundingReply:
        self.looked += 1
        box = Box(left=CUP[0], top=CUP[1], right=CUP[2], bottom=CUP[3], score=0.9)
        seen = [
            PhraseEvidence(phrase=p, found=p == "cup", score=0.9, boxes=[box] * (p == "cup"),
                           point=(50.0, 30.0) if p == "cup" else None)
            for p in request.phrases
        ]  # fmt: skip
        return GroundingReply(
            model="eyes", width=SIZE[1], height=SIZE[0], evidence=seen, milliseconds=1.0
        )


@pytest.fixture
def models(monkeypatch: pytest.MonkeyPatch) -> Models:
    made = Models()
    monkeypatch.setattr(trial, "service", made.service)
    return made


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw nothing: drawing takes longer than all else here."""
    monkeypatch.setattr(commands, "write_figure", lambda *_: None)
    monkeypatch.setattr(commands, "write_examples", lambda *_: None)


@pytest.fixture
def dataset(tmp_path: Path) -> Path:
    """Return four pictures: on the cup, on what is not seen, left of the cup twice."""
    folder = tmp_path / "dataset"
    rows = (
        ("on", "lean on the cup", "absolute", CUP),
        ("lost", "lean on the spoon", "absolute", (0.0, 0.0, 9.0, 9.0)),
        ("left", "lean left of the cup", "relative", (20.0, 20.0, 39.0, 40.0)),
        ("far", "lean left of the cup", "relative", (0.0, 20.0, 12.0, 40.0)),
    )
    (folder / "images").mkdir(parents=True)
    (folder / "masks").mkdir()
    lines = []
    for name, prompt, position, (left, top, right, bottom) in rows:
        mask = np.zeros(SIZE, np.uint8)
        mask[int(top) : int(bottom), int(left) : int(right)] = 255
        cv2.imwrite(str(folder / "masks" / f"{name}.png"), mask)
        cv2.imwrite(str(folder / "images" / f"{name}.png"), np.full((*SIZE, 3), 90, np.uint8))
        things = [{"words": prompt.split()[-1], "box": list(CUP)}]
        line = {"id": name, "prompt": prompt, "position": position, "things": things}
        lines.append(json.dumps(line) + "\n")
    (folder / "prompts.jsonl").write_text("".join(lines))
    return folder


def run(dataset: Path, *flags: str) -> int:
    directory = str(dataset.parent / "run")
    return evaluate(["--dataset", str(dataset), "--run-directory", directory, *flags])


def rows_of(dataset: Path) -> dict[tuple[str, str], Any]:
    document = json.loads((dataset.parent / "run" / "results.json").read_text())
    return {(row["case"], row["metric"]): row for row in document["rows"]}


def test_hits_misses_and_the_steps_that_went_wrong(
    dataset: Path, models: Models, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(dataset, "--llm", "some.gguf") == 0
    rows = rows_of(dataset)
    label = "some + embedded"

    assert rows[label, "success.absolute"]["value"] == 0.5
    assert rows[label, "success.relative"]["value"] == 0.5
    assert rows[label, "success.overall"]["value"] == 0.5
    assert rows[label, "success.overall"]["n"] == 4
    assert rows[label, "error.segmentation"]["value"] == 0.25
    assert rows[label, "error.expression"]["value"] == 0.25
    assert rows["random points", "success.absolute"]["n"] == 4
    said = capsys.readouterr().out
    assert "| some | embedded | embedded | 0.50 [0.50, 0.50] |" in said
    assert "| random points |" in said and "another task" in said
    directory = dataset.parent / "run"
    assert (directory / "success.svg").read_text().count("<svg") == 1
    for name in ("hits", "misses"):
        assert cv2.imread(str(directory / "pictures" / "some_embedded" / f"{name}.jpg")) is not None


@pytest.mark.usefixtures("no_pictures")
def test_every_combination_is_asked_and_each_model_is_loaded_once(
    dataset: Path, models: Models
) -> None:
    names = ("--llm", "a.gguf", "b.gguf", "--detector", "x", "y", "--segmenter", "x")

    assert run(dataset, *names, "--repetitions", "3") == 0

    cases = {case for case, _ in rows_of(dataset)}
    assert cases == {"a + x", "a + y / x", "b + x", "b + y / x", "random points"}
    assert sorted(models.loaded) == ["a", "b", "x", "y"]
    assert models.completed == 2 * 4  # what was asked before is remembered


@pytest.mark.usefixtures("no_pictures")
def test_a_temperature_makes_repetitions_differ(dataset: Path, models: Models) -> None:
    flags = ("--llm", "a.gguf", "--repetitions", "3", "--temperature", "0.7")

    assert run(dataset, *flags) == 0
    assert models.completed == 3 * 4


@pytest.mark.usefixtures("no_pictures")
def test_what_is_done_is_not_asked_again(dataset: Path, models: Models) -> None:
    assert run(dataset, "--llm", "a.gguf") == 0
    path = dataset.parent / "run" / "answers.jsonl"
    whole = path.read_text()
    path.write_text("\n".join(whole.splitlines()[:3]) + '\n{"models": ["cut')
    models.loaded.clear()

    assert run(dataset, "--llm", "a.gguf", "--resume") == 0
    assert sorted(path.read_text().splitlines()) == sorted(whole.splitlines())
    models.loaded.clear()
    assert run(dataset, "--llm", "a.gguf", "--resume") == 0
    assert models.loaded == []
    with pytest.raises(ConfigError, match="this study asks"):
        run(dataset, "--llm", "a.gguf", "--resume", "--temperature", "1")


@pytest.mark.usefixtures("no_pictures")
def test_answers_about_other_pictures_are_refused(dataset: Path, models: Models) -> None:
    del models
    assert run(dataset, "--llm", "a.gguf") == 0
    picture = next((dataset / "images").iterdir())
    picture.write_bytes(picture.read_bytes() + b"another end")

    with pytest.raises(ConfigError, match="this study asks"):
        run(dataset, "--llm", "a.gguf", "--resume")


@pytest.mark.usefixtures("no_pictures")
def test_answers_of_an_embedded_model_that_was_trained_anew_since_are_asked_again(
    dataset: Path, models: Models, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run(dataset, "--llm", "a.gguf") == 0
    before = rows_of(dataset)
    models.loaded.clear()

    monkeypatch.setattr(combinations, "checksum_of_embedded", lambda _: "other weights")
    assert run(dataset, "--llm", "a.gguf", "--resume") == 0
    assert models.loaded == ["a", "embedded"]
    assert rows_of(dataset) == before


@pytest.mark.usefixtures("no_pictures")
def test_a_model_that_is_not_there_leaves_the_others(
    dataset: Path, models: Models, capsys: pytest.CaptureFixture[str]
) -> None:
    flags = ("--llm", "a.gguf", "--detector", "broken", "embedded")

    assert run(dataset, *flags) == 1
    said = capsys.readouterr().out
    assert "- a + broken / embedded: broken: no file at models/broken" in said
    assert rows_of(dataset)["a + embedded", "success.overall"]["n"] == 4


@pytest.mark.usefixtures("no_pictures")
def test_true_boxes_leave_only_words_to_be_misunderstood(
    dataset: Path, models: Models, capsys: pytest.CaptureFixture[str]
) -> None:
    flags = ("--llm", "a.gguf", "--detector", "truth", "--segmenter", "truth")

    assert run(dataset, *flags) == 0
    rows = rows_of(dataset)
    assert rows["a + truth", "success.absolute"]["value"] == 1.0
    assert rows["a + truth", "error.expression"]["value"] == 0.25
    assert models.loaded == ["a"]
    lines = (dataset / "prompts.jsonl").read_text().splitlines()
    bare = [{k: v for k, v in json.loads(line).items() if k != "things"} for line in lines]
    (dataset / "prompts.jsonl").write_text("\n".join(json.dumps(line) for line in bare))
    assert run(dataset, *flags) == 1
    assert "on and 3 more have no `things`" in capsys.readouterr().out


def test_a_dataset_with_faults_is_refused(dataset: Path, models: Models) -> None:
    (dataset / "masks" / "on.png").unlink()

    with pytest.raises(ConfigError, match="no sound benchmark"):
        run(dataset)


def test_points_by_chance_hit_as_often_as_masks_are_large(dataset: Path) -> None:
    rates = random_rates(load(dataset), 0)
    shares = {"absolute": (400 + 81) / 2, "relative": (19 * 20 + 12 * 20) / 2}

    for name, pixels in shares.items():
        assert np.mean(rates[name]) == pytest.approx(pixels / (SIZE[0] * SIZE[1]), abs=0.03)
    assert rates == random_rates(load(dataset), 0)


def test_a_mask_accepts_its_pixels_and_nothing_outside_the_picture() -> None:
    mask = np.zeros((10, 20), bool)
    mask[9, 19] = True

    assert accepts(mask, (19.5, 9.5)) and accepts(mask, (20.0, 10.0))
    assert not accepts(mask, (18.9, 9.5))
    assert not accepts(mask, (-0.5, 9.5)) and not accepts(mask, None)


@pytest.mark.parametrize(
    ("changes", "known", "step"),
    [
        ({"module": "correction"}, True, "selector"),
        ({"position": "absolute"}, True, "analyzer"),
        ({"phrases": ("mug",)}, True, "analyzer"),
        ({"phrases": ("the Red cup.",)}, True, "expression"),
        ({"phrases": ("mug",)}, False, "detection or expression"),
        ({"boxes": ()}, True, "detection"),
        ({"boxes": (Box(left=0, top=0, right=14, bottom=20, score=1),)}, True, "expression"),
        ({"boxes": (Box(left=0, top=0, right=9, bottom=20, score=1),)}, True, "detection"),
        ({"failed": "expression"}, False, "expression"),
        ({"failed": "detection", "boxes": ()}, False, "detection"),
        ({"failed": "analyzer", "phrases": ()}, True, "analyzer"),
    ],
)
def test_the_first_wrong_step_counts(changes: dict[str, Any], known: bool, step: str) -> None:
    things = (NamedThing(words="red cup", box=(0.0, 0.0, 20.0, 20.0)),)
    record = Record(id="a", prompt="x", position="relative", things=things if known else None)
    right = {
        "failed": "", "module": "prediction", "position": "relative", "phrases": ("red cup",),
        "boxes": (Box(left=0, top=0, right=20, bottom=20, score=1),),
    }  # fmt: skip

    assert first_error(record, SimpleNamespace(**(right | changes))) == step


def test_overlap_is_intersection_over_union() -> None:
    assert overlap((0, 0, 10, 10), (5, 0, 15, 10)) == pytest.approx(1 / 3)
    assert overlap((0, 0, 10, 10), (10, 0, 15, 10)) == 0.0


def test_the_papers_twelve_combinations_are_a_preset_with_its_figures() -> None:
    combinations = chosen(Config(dataset="x", preset="paper"))

    assert [one.names for one in combinations] == list(paper.TABLE)
    assert len({one.digest for one in combinations}) == 12
    table = success_table({}, {"absolute": [0.1]}, {})
    assert "0.10 [0.10, 0.10]" in table and "0.12 / 0.17 / 0.13" in table


def test_no_two_combinations_share_a_label() -> None:
    combinations = Catalogue([]).combine(["embedded"], ["embedded", "truth"], ["embedded", "truth"])

    assert [one.label for one in combinations] == [
        "embedded",
        "embedded + embedded / truth",
        "embedded + truth / embedded",
        "embedded + truth",
    ]


def test_names_of_a_file_come_first_and_say_which_prompts(tmp_path: Path) -> None:
    path = tmp_path / "models.toml"
    path.write_text(
        '[llm.mine]\nmodel = "m.gguf"\nprompts = "embedded"\n[vision.eyes]\nmodel="e"\n'
    )
    catalogue = Catalogue([path])

    assert catalogue.language_model("mine").prompts == "embedded"
    assert catalogue.vision_model("eyes").flags == {"model": "e"}
    assert catalogue.vision_model("clipseg").flags == {"model": "clipseg"}
    assert catalogue.language_model("openai:gpt").flags == {"backend": "openai", "model": "gpt"}
    with pytest.raises(ConfigError, match="no language model 'other'"):
        catalogue.language_model("other")
    path.write_text("[lllm.mine]\n")
    with pytest.raises(ConfigError, match="unknown tables lllm"):
        Catalogue([path])


def test_the_vision_models_of_the_paper_are_names_that_grounding_knows() -> None:
    from w2c_grounding.known import KNOWN
    from w2c_grounding.registry import FAMILIES

    vision = tomllib.loads(paper.PRESET_FILE.read_text())["vision"]
    assert set(vision) == {*paper.DETECTORS, *paper.SEGMENTERS}
    assert all(flags["model"] in KNOWN for flags in vision.values())
    assert all(KNOWN[flags["model"]].family in FAMILIES for flags in vision.values())
