"""`w2c evaluate language`: what people say, held out of training, through `dialogue batch`."""

import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec

from w2c.config import parse
from w2c.errors import ConfigError, ProcessError
from w2c_evaluation.results import make_results, origin, write_results
from w2c_evaluation.understanding.card import fill_card
from w2c_evaluation.understanding.judging import HeldOut, score, turns_right

HELD_OUT_FILES = Path(__file__).parent / "held_out"
TARGETS = {
    "select": 0.97,
    "analyze.position": 0.95,
    "analyze.objects": 0.90,
    "effector": 0.97,
    "relative": 0.85,
    "correct": 0.85,
    "dialogue.turns": 0.95,
}


class LanguageConfig(msgspec.Struct, frozen=True, kw_only=True):
    """How often what people say is understood, on sentences that no training saw."""

    questions: tuple[str, ...] = ()
    """Files of questions with answers, JSON lines; none = those of this repository."""
    model: str = ""
    """GGUF file; empty = the embedded model."""
    prompts: str = "embedded"
    """Prompt set: embedded or large."""
    seed: int = 0
    """Seed of the language model's answers."""
    run_directory: str = ""
    """Where everything goes; empty = runs/<date and time>-language."""
    json: str = ""
    """Write the results to this file; empty = results.json in the run directory."""
    card: str = ""
    """Write the scores into this card, which `train language` wrote beside the model."""
    table: str = ""
    """Write the tables to this Markdown file; empty = tables.md in the run directory."""


Judged = dict[str, dict[str, list[bool]]]
"""What was judged -> voice -> whether right"""


def evaluate(arguments: list[str] | None = None) -> int:
    """Ask and judge. Exit status 0 when every target is met.

    Raises:
        ConfigError: a file of questions is missing or malformed.
        ProcessError: the batch could not be run.
    """
    config = parse(LanguageConfig, arguments or [], program="w2c evaluate language")
    lines = read_questions([Path(name) for name in config.questions])
    stamp = time.strftime("%Y-%m-%d_%H-%M-%S")
    directory = Path(config.run_directory or f"runs/{stamp}-language").resolve()
    directory.mkdir(parents=True, exist_ok=True)
    (directory / "in.jsonl").write_bytes(b"\n".join(lines) + b"\n")
    answers = _ask(config, directory)
    held_out = [msgspec.json.decode(line, type=HeldOut) for line in lines]
    judged = judge(held_out, answers)
    _write_misses(directory / "misses.jsonl", lines, held_out, answers)
    document = make_results("understanding", config.seed, rows_of(judged))
    document |= {"model": config.model or "embedded", "prompts": config.prompts}
    write_results(document, Path(config.json) if config.json else directory / "results.json")
    tables = f"# Sentences understood\n\n{format_table(judged)}\n\n{origin(document)}\n"
    (Path(config.table) if config.table else directory / "tables.md").write_text(tables)
    if config.card:
        fill_card(Path(config.card), f"{format_table(judged)}\n\n{origin(document)}")
    print(f"{tables}\nall of it, misses too: {directory}")
    return 0 if all(rate(judged[name]) >= target for name, target in TARGETS.items()) else 1


def read_questions(paths: Sequence[Path]) -> list[bytes]:
    """Return the lines of files, or of the held-out files of this repository.

    Raises:
        ConfigError: a file cannot be read, or a line is no question with an answer.
    """
    sources = list(paths) or sorted(HELD_OUT_FILES.glob("*.jsonl"))
    lines: list[bytes] = []
    for source in sources:
        try:
            found = source.read_bytes().splitlines()
        except OSError as error:
            raise ConfigError(f"{source} cannot be read: {error.strerror}") from error
        for number, line in enumerate(found, 1):
            try:
                msgspec.json.decode(line, type=HeldOut)
            except (msgspec.MsgspecError, ValueError) as error:
                raise ConfigError(f"{source.name}, line {number}: {error}") from error
        lines += found
    return lines


def judge(lines: Sequence[HeldOut], answers: Sequence[dict[str, Any]]) -> Judged:
    """Return what is right of the answers to lines, in the same order."""
    judged: Judged = defaultdict(lambda: defaultdict(list))
    for line, answer in zip(lines, answers, strict=True):
        for name, right in score(line, answer).items():
            judged[name][line.voice].append(right)
        if line.task == "dialogue":
            judged["dialogue.turns"][line.voice] += turns_right(line, answer)
    return judged


def rate(voices: dict[str, list[bool]]) -> float:
    """Return the share that is right over all voices, 0 where nothing was judged."""
    every = [right for answers in voices.values() for right in answers]
    return sum(every) / len(every) if every else 0.0


def rows_of(judged: Judged) -> list[dict[str, Any]]:
    """Return the rows of the results file: each task over all voices, and each of its voices."""
    rows = []
    for name, voices in judged.items():
        for voice, answers in [("all", [r for v in voices.values() for r in v]), *voices.items()]:
            share = sum(answers) / len(answers)
            low, high = wilson_interval(sum(answers), len(answers))
            rows.append(
                {
                    "case": name if voice == "all" else f"{name}.{voice}",
                    "metric": "right",
                    "value": share,
                    "unit": "rate",
                    "n": len(answers),
                    "spread": [low, high],
                }
            )
    return rows


def wilson_interval(right: int, count: int, z: float = 1.96) -> tuple[float, float]:
    """Return the 95 % interval of a rate (Wilson 1927)."""
    share = right / count
    centre = share + z * z / (2 * count)
    half = z * ((share * (1 - share) + z * z / (4 * count)) / count) ** 0.5
    scale = 1 + z * z / count
    return (centre - half) / scale, (centre + half) / scale


def format_table(judged: Judged) -> str:
    """Return a Markdown table: tasks down, voices across."""
    voices = sorted({voice for answers in judged.values() for voice in answers})
    head = ["task", "target", "right", "n", "95 %", *voices]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for name, by_voice in judged.items():
        every = [right for answers in by_voice.values() for right in answers]
        low, high = wilson_interval(sum(every), len(every))
        cells = [name, f"{TARGETS[name]:.2f}" if name in TARGETS else "", f"{rate(by_voice):.3f}"]
        cells += [str(len(every)), f"{low:.2f} to {high:.2f}"]
        for voice in voices:
            answers = by_voice.get(voice, [])
            cells.append(f"{sum(answers)}/{len(answers)}" if answers else "")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _ask(config: LanguageConfig, directory: Path) -> list[dict[str, Any]]:
    """Return the answers of `dialogue batch`, one a line."""
    command = [sys.executable, "-m", "w2c.cli", "dialogue", "batch"]
    command += ["--in", str(directory / "in.jsonl"), "--out", str(directory / "out.jsonl")]
    command += ["--prompts", config.prompts, "--seed", str(config.seed)]
    if config.model:
        command += ["--model", str(Path(config.model).resolve())]
    status = subprocess.run(command, check=False).returncode
    if status != 0:
        raise ProcessError(f"`{' '.join(command)}` ended with {status}; its errors are above")
    return [msgspec.json.decode(line) for line in (directory / "out.jsonl").open("rb")]


def _write_misses(
    path: Path,
    lines: Sequence[bytes],
    held_out: Sequence[HeldOut],
    answers: Sequence[dict[str, Any]],
) -> None:
    """Write every line that was not wholly right with its answer, for a person to read."""

    def misses() -> Iterator[bytes]:
        for text, line, answer in zip(lines, held_out, answers, strict=True):
            if not all(score(line, answer).values()):
                yield msgspec.json.encode({**msgspec.json.decode(text), "answer": answer})

    path.write_bytes(b"".join(miss + b"\n" for miss in misses()))
