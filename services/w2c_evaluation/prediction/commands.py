"""`w2c evaluate prediction`."""

import hashlib
import re
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from w2c.config import parse
from w2c.errors import ConfigError
from w2c_evaluation.benchmark.dataset import Item, load
from w2c_evaluation.pool import ResultFile
from w2c_evaluation.prediction import paper
from w2c_evaluation.prediction.combinations import EMBEDDED, Catalogue, Combination
from w2c_evaluation.prediction.figure import write_examples, write_figure
from w2c_evaluation.prediction.judging import Answer
from w2c_evaluation.prediction.report import format_tables, make_rows, rates_of
from w2c_evaluation.prediction.trial import (
    Absent,
    Options,
    count_missing,
    key_of,
    random_rates,
    run,
)
from w2c_evaluation.results import make_results, origin, write_results, write_text

Ablation = Literal["none", "direct_number", "no_reasoning", "zero_shot", "single_prompt"]


class PredictionConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Success rate of combinations of models on pictures with prompts and masks, as in Table I.

    Every language model is combined with every detector and every segmenter; points by chance
    stand beside them. Models are named as docs/how-to/benchmarks.md says.
    """

    dataset: str
    """Folder of pictures, prompts and masks; `w2c benchmark make` makes one."""
    llm: tuple[str, ...] = (EMBEDDED,)
    """Language models."""
    detector: tuple[str, ...] = (EMBEDDED,)
    """Vision models that find boxes, for relative positions."""
    segmenter: tuple[str, ...] = (EMBEDDED,)
    """Vision models that find areas, for absolute positions."""
    preset: Literal["", "paper"] = ""
    """paper: the twelve combinations of the paper's Table I, instead of the three flags above."""
    models: tuple[str, ...] = ()
    """Files (TOML) that say what names of models mean."""
    repetitions: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 1
    """Of every prompt; without a temperature all of them come out the same."""
    temperature: Annotated[float, msgspec.Meta(ge=0.0, le=10.0)] = 0.0
    """Of the language model: above 0, repetitions differ."""
    ablation: Ablation = "none"
    """What is taken out of the prompts of a general model: its examples (zero_shot), its chain of
    thought (no_reasoning), the parser of its arithmetic (direct_number), or the split into modules
    (single_prompt)."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of the language model's answers, and of points by chance."""
    run_directory: str = ""
    """Where everything goes; empty = runs/<date and time>-prediction."""
    resume: bool = False
    """Go on with what the run directory has already."""
    json: str = ""
    """Write the results to this file; empty = results.json in the run directory."""
    table: str = ""
    """Write the tables to this Markdown file; empty = tables.md in the run directory."""
    image: str = ""
    """Write the figure to this SVG file; empty = success.svg in the run directory."""


def evaluate(arguments: list[str] | None = None) -> int:
    """Ask, judge and report. Exit status 1 where a combination could not be asked.

    Raises:
        ConfigError: the dataset is not sound, a model has no meaning, an ablation does not fit.
    """
    config = parse(PredictionConfig, arguments or [], program="w2c evaluate prediction")
    combinations = chosen(config)
    items = load(Path(config.dataset))
    stamp = time.strftime("%Y-%m-%d_%H-%M-%S")
    directory = Path(config.run_directory or f"runs/{stamp}-prediction").resolve()
    question = {
        "prompts": _digest(items),
        "seed": config.seed,
        "temperature": config.temperature,
        "ablation": config.ablation,
    }
    file = ResultFile(directory / "answers.jsonl", question, Answer)
    answers = {key_of(answer): answer for answer in file.start(resume=config.resume)}
    options = Options(config.repetitions, config.seed, config.temperature, config.ablation)
    absent: dict[Combination, str] = {}
    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(elapsed_when_finished=True),
    )
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        missing = count_missing(items, combinations, options, answers.keys())
        bar = progress.add_task("prompts", total=missing)
        for result in run(items, combinations, options, answers.keys()):
            if isinstance(result, Absent):
                absent[result.combination] = result.reason
                progress.advance(bar, len(items) * config.repetitions)
                continue
            file.add(result)
            answers[key_of(result)] = result
            progress.advance(bar)
    given = {one: _of(one, answers.values(), config.repetitions) for one in combinations}
    return _report(config, directory, items, {o: a for o, a in given.items() if a}, absent)


def chosen(config: PredictionConfig) -> list[Combination]:
    """Return the combinations that the flags ask for. Raises ConfigError."""
    files = [Path(name) for name in config.models]
    if config.preset == "paper":
        catalogue = Catalogue([paper.PRESET_FILE, *files])
        return catalogue.combine(paper.LANGUAGE_MODELS, paper.DETECTORS, paper.SEGMENTERS)
    combinations = Catalogue(files).combine(config.llm, config.detector, config.segmenter)
    if not combinations:
        raise ConfigError("no combination: --llm, --detector and --segmenter need a name each")
    return combinations


def _of(combination: Combination, answers: Iterable[Answer], repetitions: int) -> list[Answer]:
    """Return the answers of a combination, in order."""
    found = [a for a in answers if a.digest == combination.digest and a.repetition < repetitions]
    return sorted(found, key=lambda answer: (answer.repetition, answer.id))


def _report(
    config: PredictionConfig,
    directory: Path,
    items: Sequence[Item],
    answers: dict[Combination, list[Answer]],
    absent: dict[Combination, str],
) -> int:
    """Write and print everything; return the exit status."""
    random = random_rates(items, config.seed)
    records = {item.record.id: item.record for item in items}
    document = make_results("prediction", config.seed, make_rows(answers, random, items))
    document |= {
        "dataset": Path(config.dataset).resolve().name,
        "prompts": _digest(items),
        "ablation": config.ablation,
        "temperature": config.temperature,
        "repetitions": config.repetitions,
        "absent": {one.label: reason for one, reason in absent.items()},
    }
    write_results(document, Path(config.json) if config.json else directory / "results.json")
    ablation = f", {config.ablation}" if config.ablation != "none" else ""
    tables = (
        f"# Predicted points that are accepted{ablation}\n\n"
        f"{format_tables(answers, random, items, absent)}\n\n"
        f"{len(items)} pictures, {config.repetitions} repetitions at temperature "
        f"{config.temperature:g}. {origin(document)}\n"
    )
    write_text(tables, Path(config.table) if config.table else directory / "tables.md")
    image = Path(config.image) if config.image else directory / "success.svg"
    write_figure({o.label: rates_of(a, records) for o, a in answers.items()}, random, image)
    for combination, given in answers.items():
        name = re.sub(r"[^A-Za-z0-9.-]+", "_", combination.label)
        write_examples(given, items, directory / "pictures" / name)
    print(f"{tables}\nall of it, pictures too: {directory}")
    return 1 if absent else 0


def _digest(items: Sequence[Item]) -> str:
    """Return a short text that is another one for other prompts, pictures or masks."""
    hasher = hashlib.blake2b(digest_size=8)
    for item in items:
        hasher.update(msgspec.json.encode(item.record))
        hasher.update(item.picture())
        hasher.update(item.mask.read_bytes())
    return hasher.hexdigest()
