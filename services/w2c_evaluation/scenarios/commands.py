"""`w2c evaluate scenarios`."""

import logging
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from w2c.config import parse
from w2c.logs import configure_logs
from w2c_evaluation.embedded import checksum_of_embedded
from w2c_evaluation.pool import ResultFile
from w2c_evaluation.results import make_results, origin, write_results
from w2c_evaluation.scenarios.experiments import EXPERIMENTS, Experiment, find_experiment
from w2c_evaluation.scenarios.film import make_strip
from w2c_evaluation.scenarios.record import RunResult
from w2c_evaluation.scenarios.report import by_case, describe, format_table, make_rows
from w2c_evaluation.scenarios.run import RunOptions, run_scenario

TARGET_RATE = 0.95
MARKS = {"boxes": {"truth": "boxes from truth"}, "words": {"scripted": "scripted words"}}


class ScenariosConfig(msgspec.Struct, frozen=True, kw_only=True):
    """The paper's four experiments in the simulator, with a scripted operator, in lock step."""

    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of the first layout."""
    seeds: Annotated[int, msgspec.Meta(ge=1, le=10_000)] = 1
    """How many layouts of each scenario."""
    scenarios: tuple[str, ...] = tuple(EXPERIMENTS)
    """Which ones: a b c d."""
    boxes: Literal["model", "truth"] = "model"
    """Who finds things in pictures: the grounding service, or the simulator's truth."""
    words: Literal["model", "scripted"] = "model"
    """Who understands words: the llm service, or a script that knows what is meant."""
    jobs: Annotated[int, msgspec.Meta(ge=1, le=64)] = 1
    """Runs at a time; each takes about one and a half cores."""
    keep: bool = False
    """Keep the recordings of successes, too: 30 to 100 MB each."""
    run_directory: str = ""
    """Where everything goes; empty = runs/<date and time>-scenarios."""
    resume: bool = False
    """Go on with what the run directory has already."""
    json: str = ""
    """Write the results to this file; empty = results.json in the run directory."""
    table: str = ""
    """Write the tables to this Markdown file; empty = tables.md in the run directory."""
    image: str = ""
    """Write a film strip of each scenario into this directory; empty = the run directory."""


def evaluate(arguments: list[str] | None = None) -> int:
    """Run the scenarios. Exit status 0 when 95 % succeeded, nothing fell and nothing moved unasked.

    Raises ConfigError for a scenario that does not exist.
    """
    config = parse(ScenariosConfig, arguments or [], program="w2c evaluate scenarios")
    chosen = [find_experiment(name) for name in config.scenarios]
    directory = Path(
        config.run_directory or f"runs/{time.strftime('%Y-%m-%d_%H-%M-%S')}-scenarios"
    ).resolve()
    directory.mkdir(parents=True, exist_ok=True)
    configure_logs("scenarios", "info", str(directory))
    question = {
        "boxes": config.boxes,
        "words": config.words,
        "weights": [
            checksum_of_embedded("language_service") if config.words == "model" else "",
            checksum_of_embedded("grounding_service") if config.boxes == "model" else "",
        ],
    }
    file = ResultFile(directory / "runs.jsonl", question, RunResult)
    done = {(r.scenario, r.seed): r for r in file.start(resume=config.resume)}
    wanted = [
        (experiment, seed)
        for seed in range(config.seed, config.seed + config.seeds)
        for experiment in chosen
    ]
    missing = [
        (experiment, seed) for experiment, seed in wanted if (experiment.name, seed) not in done
    ]
    for result in _run_all(missing, config, directory):
        file.add(result)
        done[result.scenario, result.seed] = result
        print(describe(result), flush=True)
    results = [done[experiment.name, seed] for experiment, seed in wanted]
    return _report(config, directory, results)


def _run_all(
    runs: list[tuple[Experiment, int]], config: ScenariosConfig, directory: Path
) -> Iterator[RunResult]:
    """Yield the results of runs as they end, `jobs` of them at a time."""

    def run(experiment: Experiment, seed: int) -> RunResult:
        run_directory = directory / f"{experiment.name}-{seed}"
        options = RunOptions(run_directory, config.boxes, config.words, config.keep)
        return run_scenario(experiment, seed, options)

    if config.jobs == 1:
        yield from (run(*one) for one in runs)
        return
    # Threads: all the work is in the processes of the systems.
    with ThreadPoolExecutor(config.jobs) as pool:
        running = [pool.submit(run, *one) for one in runs]
        try:
            yield from (future.result() for future in as_completed(running))
        finally:
            pool.shutdown(cancel_futures=True)


def _report(config: ScenariosConfig, directory: Path, results: list[RunResult]) -> int:
    """Write and print everything; return the exit status."""
    document = make_results("scenarios", config.seed, make_rows(results))
    document |= {"boxes": config.boxes, "words": config.words}
    write_results(document, Path(config.json) if config.json else directory / "results.json")
    marks = [names[value] for key, names in MARKS.items() if (value := document[key]) in names]
    title = f"# Scenarios{' with ' + ' and '.join(marks) if marks else ''}"
    tables = f"{title}\n\n{format_table(results)}\n\n{origin(document)}\n"
    (Path(config.table) if config.table else directory / "tables.md").write_text(tables)
    images = Path(config.image) if config.image else directory
    for name, runs in by_case(results).items():
        shown = next((run for run in runs if run.succeeded), runs[0])
        if name in EXPERIMENTS:
            make_strip(directory / shown.images, images / f"scenario_{name}.jpg")
    print(f"\n{tables}\nall of it: {directory}")
    good = sum(result.succeeded for result in results)
    clean = not any(result.fell or result.unconfirmed_motions for result in results)
    logging.getLogger("w2c.scenarios").info("%d of %d succeeded", good, len(results))
    return 0 if clean and good >= TARGET_RATE * len(results) else 1
