"""What the documents show exists: every verb, every flag, every make target, every linked file."""

import json
import re
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import msgspec
import pytest

from support.documents import ROOT, commands_of, documents
from w2c.tables import calls_table, streams_table
from w2c_evaluation.grounding.report import format_table as grounding_table
from w2c_evaluation.language.report import format_table as language_table
from w2c_evaluation.perception.report import format_table as perception_table
from w2c_evaluation.results import results_table
from w2c_evaluation.understanding.commands import read_questions
from w2c_evaluation.understanding.judging import HeldOut
from w2c_grounding.model_list import models_table
from w2c_sim_robot.scenes.tables import kinds_table

LINK = re.compile(r"\]\((?!https?:)([^)#]+)")
ANCHOR = re.compile(r"\]\((?!https?:)([^)#]*)#([^)]+)\)")
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)
OTHER_PROGRAMS = {"git", "cd", "docker", "curl", "sudo", "python", "scp", "ssh", "bash"}

SCENES = ROOT / "docs" / "reference" / "scenes.md"
REFERENCE = ROOT / "docs" / "reference" / "messages.md"
RESULTS = ROOT / "docs" / "results" / "demo.json"
PERCEPTION = ROOT / "docs" / "results" / "perception.json"
CAMERA = ROOT / "docs" / "results" / "camera.json"
CONTROL = ROOT / "docs" / "results" / "control.json"
LANGUAGE = ROOT / "docs" / "results" / "language.json"
GROUNDING = ROOT / "docs" / "results" / "grounding.json"
RECORDING = ROOT / "docs" / "results" / "recording.json"
DEMO_KILLS = ROOT / "docs" / "results" / "recording_demo_kills.json"
UNDERSTANDING = ROOT / "docs" / "results" / "understanding.json"
CORRECTIONS = ROOT / "docs" / "results" / "corrections.json"
VOICES = tuple(f".{msgspec.json.decode(line, type=HeldOut).voice}" for line in read_questions([]))


def control_table() -> str:
    """Return what whole ticks take; the results file has their parts too."""
    results = json.loads(CONTROL.read_text())
    whole = ("tick_cpu_median", "tick_cpu_p99")
    rows = [row for row in results["rows"] if row["metric"] in whole]
    return results_table({**results, "rows": rows})


def understanding_table() -> str:
    """Return the rates over all voices; the results file has each voice too."""
    results = json.loads(UNDERSTANDING.read_text())
    rows = [row for row in results["rows"] if not row["case"].endswith(VOICES)]
    return results_table({**results, "rows": rows})


def corrections_table() -> str:
    """Return the distances of each phase; the results file has voices and phrasings too."""
    results = json.loads(CORRECTIONS.read_text())
    rows = [row for row in results["rows"] if "." not in row["case"]]
    return results_table({**results, "rows": rows})


TABLES: dict[str, tuple[Path, Callable[[], str]]] = {
    "control": (ROOT / "docs" / "how-to" / "benchmarks.md", control_table),
    "camera": (
        ROOT / "docs" / "how-to" / "benchmarks.md",
        lambda: results_table(json.loads(CAMERA.read_text())),
    ),
    "language": (
        ROOT / "docs" / "how-to" / "benchmarks.md",
        lambda: language_table(json.loads(LANGUAGE.read_text())),
    ),
    "corrections": (ROOT / "docs" / "how-to" / "benchmarks.md", corrections_table),
    "grounding": (
        ROOT / "docs" / "how-to" / "benchmarks.md",
        lambda: grounding_table(json.loads(GROUNDING.read_text())),
    ),
    "understanding": (ROOT / "docs" / "how-to" / "benchmarks.md", understanding_table),
    "recording_demo_kills": (
        ROOT / "docs" / "how-to" / "recordings.md",
        lambda: results_table(json.loads(DEMO_KILLS.read_text())),
    ),
    "recording": (
        ROOT / "docs" / "how-to" / "recordings.md",
        lambda: results_table(json.loads(RECORDING.read_text())),
    ),
    "streams": (REFERENCE, streams_table),
    "calls": (REFERENCE, calls_table),
    "kinds": (SCENES, kinds_table),
    "vision_models": (ROOT / "docs" / "reference" / "vision-models.md", models_table),
    "perception": (
        ROOT / "docs" / "how-to" / "perception.md",
        lambda: perception_table(json.loads(PERCEPTION.read_text())),
    ),
    "results": (ROOT / "README.md", lambda: results_table(json.loads(RESULTS.read_text()))),
}

COMMANDS = sorted(
    {
        (str(path.relative_to(ROOT)), tuple(words))
        for path in documents()
        for words in commands_of(path)
    }
)


@cache
def help_of(verb: tuple[str, ...]) -> str:
    """Return what `w2c VERB --help` prints."""
    answer = subprocess.run(
        [sys.executable, "-m", "w2c.cli", *verb, "--help"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode == 0, answer.stderr
    return answer.stdout


@pytest.mark.parametrize("document", documents(), ids=lambda p: p.name)
def test_every_linked_file_exists(document: Path) -> None:
    missing = [
        link for link in LINK.findall(document.read_text()) if not (document.parent / link).exists()
    ]
    assert missing == []


@cache
def anchors_of(document: Path) -> set[str]:
    """Return what a link into a page may name: its headings, as GitHub writes them."""
    headings = HEADING.findall(document.read_text())
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("document", documents(), ids=lambda p: p.name)
def test_every_linked_heading_exists(document: Path) -> None:
    missing = [
        f"{file}#{anchor}"
        for file, anchor in ANCHOR.findall(document.read_text())
        if anchor not in anchors_of((document.parent / file).resolve() if file else document)
    ]
    assert missing == []


@pytest.mark.parametrize(
    ("document", "words"), COMMANDS, ids=lambda v: v if isinstance(v, str) else " ".join(v)
)
def test_every_shown_command_exists_with_its_flags(document: str, words: tuple[str, ...]) -> None:
    program = Path(words[0]).name
    if program == "make":
        makefile = (ROOT / "Makefile").read_text()
        for target in (word for word in words[1:] if "=" not in word):
            assert re.search(rf"^{target}:", makefile, re.MULTILINE), f"make {target} in {document}"
        return
    if program != "w2c":
        assert program in OTHER_PROGRAMS, f"{program} in {document}"
        return
    verb = (
        words[1:3]
        if words[1] in ("bench", "evaluate", "benchmark", "train", "scenes", "dialogue")
        and (len(words) > 2 and not words[2].startswith("-"))
        else words[1:2]
    )
    text = help_of(tuple(verb))
    for flag in (word.partition("=")[0] for word in words if word.startswith("--")):
        assert flag in text, f"{flag} of '{' '.join(words)}' in {document}"


@pytest.mark.parametrize("name", sorted(TABLES))
def test_tables_are_what_they_are_made_from(name: str, request: pytest.FixtureRequest) -> None:
    """Make them again with --accept-golden."""
    document, table = TABLES[name]
    marker = re.compile(rf"(<!-- {name} -->\n).*?(\n<!-- end -->)", re.DOTALL)
    text = document.read_text()
    assert marker.search(text)
    expected = marker.sub(lambda match: match[1] + table() + match[2], text)
    if request.config.getoption("--accept-golden"):
        document.write_text(expected)
    assert document.read_text() == expected
