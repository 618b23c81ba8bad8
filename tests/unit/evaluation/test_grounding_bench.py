"""`w2c bench grounding`: what is timed, and what is said of it."""

import json
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fakes.vision import FakeFamily
from w2c.errors import ModelError, ProcessError
from w2c_evaluation.grounding import commands
from w2c_evaluation.grounding.report import format_table, make_rows, missed
from w2c_evaluation.results import make_results
from w2c_grounding.bench.costs import Costs, Question, Spent, measure, new_phrases, new_pictures
from w2c_grounding.card import ModelCard
from w2c_grounding.family import Family
from w2c_grounding.model_config import ModelConfig

FAMILY = FakeFamily()


def load(config: ModelConfig) -> tuple[Family[Any], ModelCard]:
    assert (config.model, config.threads) == ("", 1)
    return FAMILY, ModelCard(name="fake", threshold=0.5)


def costs(one: float, five: float, device: str = "cpu") -> Costs:
    spent = {
        name: Spent([wall, wall], [2 * wall, 2 * wall])
        for name, wall in {"one_phrase": one, "five_phrases": five}.items()
    }
    return Costs("fake", device, 1.5, spent, 300.0, 400.0, None if device == "cpu" else 90.0)


def test_every_question_is_timed_with_new_pictures_and_phrases_except_the_known_one() -> None:
    found = measure(Question(model="embedded", threads=1, rounds=1), load)
    assert found is not None
    assert (found.name, found.device, found.peak_device_mb) == ("fake", "cpu", None)
    assert {name: len(spent.wall_ms) for name, spent in found.spent.items()} == {
        "one_phrase": 1, "five_phrases": 1, "five_images": 1, "known_picture": 1,
    }  # fmt: skip
    assert all(value > 0.0 for spent in found.spent.values() for value in spent.wall_ms)
    asked = FAMILY.asked[1:]  # the first is the warm-up
    assert len(asked) == 1 + 5 + 5 + 2
    assert len(set(asked)) == len(asked)
    # A warm-up; a picture, a picture and five pictures; and the known one.
    assert FAMILY.prepared == 1 + (1 + 1 + 5) + 1
    assert found.peak_memory_mb >= found.memory_mb > 0.0


def test_pictures_and_phrases_are_those_of_the_seed() -> None:
    first, second = (
        (next(new_pictures(np.random.default_rng(s))), next(new_phrases(np.random.default_rng(s))))
        for s in (1, 1)
    )
    assert first == second
    pictures = new_pictures(np.random.default_rng(1))
    assert next(pictures) != next(pictures)


def test_the_ratio_is_of_processor_time_on_a_cpu_and_of_wall_time_on_a_gpu() -> None:
    mixed = costs(10.0, 12.0)
    mixed.spent["five_phrases"].wall_ms[:] = [90.0, 90.0]
    rows = {row["metric"]: row["value"] for row in make_rows("fake", mixed)}
    assert rows["five_to_one"] == pytest.approx(1.2)
    assert rows["one_phrase_ms"] == pytest.approx(10.0)
    assert rows["one_phrase_cpu_ms"] == pytest.approx(20.0)
    assert "peak_device_mb" not in rows
    rows = {row["metric"]: row["value"] for row in make_rows("fake", costs(10.0, 12.0, "cuda"))}
    assert rows["five_to_one"] == pytest.approx(1.2)
    assert rows["peak_device_mb"] == pytest.approx(90.0)


def test_only_the_embedded_model_has_targets() -> None:
    assert missed(make_rows("embedded", costs(100.0, 140.0))) == []
    slow = missed(make_rows("embedded", costs(151.0, 140.0)))
    assert slow == ["a phrase takes 151 ms, 302 ms of processor time, target 150"]
    waiting = costs(900.0, 1000.0)
    waiting.spent["one_phrase"].cpu_ms[:] = [90.0, 90.0]
    waiting.spent["five_phrases"].cpu_ms[:] = [120.0, 120.0]
    assert missed(make_rows("embedded", waiting)) == [], "a machine with other work to do"
    steep = missed(make_rows("embedded", costs(100.0, 160.0)))
    assert steep == ["five phrases take 1.60 times as long as one, target 1.5"]
    assert missed(make_rows("large", costs(1000.0, 5000.0))) == []


def test_the_table_has_a_line_a_model() -> None:
    rows = make_rows("embedded", costs(100.0, 140.0)) + make_rows("big", costs(1000.0, 5000.0))
    table = format_table(make_results("grounding", 0, rows)).splitlines()
    assert table[2].startswith("| embedded | 100 ms | 200 ms | 140 ms | 1.4 |")
    assert table[3].startswith("| big | 1000 ms | 2000 ms | 5000 ms | 5 |")


def test_the_command_writes_the_results_and_leaves_out_what_is_not_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[dict[str, Any]] = []

    def measure_alone(question: dict[str, Any]) -> Costs | None:
        asked.append(question)
        if question["model"] == "broken":
            raise ModelError("it is damaged")
        return None if question["device"] == "cuda" else costs(100.0, 160.0)

    monkeypatch.setattr(commands, "_measure_alone", measure_alone)
    out = tmp_path / "grounding.json"
    assert commands.bench(["--models", "embedded", "mine", "--json", str(out)]) == 1
    rows = json.loads(out.read_text())["rows"]
    assert {row["case"] for row in rows} == {"embedded", "fake"}
    assert "target missed: five phrases take 1.60 times" in capsys.readouterr().out
    assert [question["device"] for question in asked] == ["cpu", "cuda", "cpu", "cuda"]
    with pytest.raises(ModelError, match="damaged"):
        commands.bench(["--models", "broken"])


def test_a_model_that_cannot_be_measured_leaves_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def measure_alone(question: dict[str, Any]) -> Costs:
        if question["model"] == "broken":
            raise ModelError("it is damaged")
        return costs(100.0, 110.0)

    monkeypatch.setattr(commands, "_measure_alone", measure_alone)
    out = tmp_path / "grounding.json"
    flags = ["--devices", "cpu", "--json", str(out), "--models"]
    assert commands.bench([*flags, "mine", "broken", "embedded"]) == 1
    assert {row["case"] for row in json.loads(out.read_text())["rows"]} == {"embedded", "fake"}
    assert "not measured: it is damaged" in capsys.readouterr().out
    assert commands.bench([*flags, "mine"]) == 0


def test_a_process_that_was_ended_is_told_as_such(monkeypatch: pytest.MonkeyPatch) -> None:
    class Pool:
        def __init__(self, *_: Any, **__: Any) -> None: ...

        def __enter__(self) -> "Pool":
            return self

        def __exit__(self, *_: object) -> None: ...

        def submit(self, *_: Any) -> "Future[Any]":
            future: Future[Any] = Future()
            future.set_exception(BrokenProcessPool("a child died"))
            return future

    monkeypatch.setattr(commands, "ProcessPoolExecutor", Pool)
    with pytest.raises(ProcessError, match=r"measured large on cuda was ended.*bfloat16"):
        commands._measure_alone({"model": "large", "device": "cuda"})
