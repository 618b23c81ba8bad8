"""`w2c demo`, and `w2c bench demo`."""

import json
import logging
import sys
import time
from pathlib import Path
from typing import Annotated, Any

import msgspec

from w2c.config import parse
from w2c.logs import configure_logs

SeedCount = Annotated[int, msgspec.Meta(ge=1, le=10_000)]


class DemoConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Play scenario (a) of the paper in the simulator, with every process of the system."""

    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of the layout and of the simulator."""
    lock_step: bool = False
    """The simulator waits for each command instead of keeping real time."""
    run_directory: str = ""
    """Where everything goes; empty = runs/<date and time>-demo."""
    json: str = ""
    """Write the summary to this file, too."""
    verbose: bool = False
    """Show the launcher's progress in full."""


def demo(arguments: list[str] | None = None) -> int:
    """Play the scenario. Exit status 0 when the hand leaned and the cup was reached."""
    from w2c_evaluation.demo.run import RunOptions, run_scenario
    from w2c_evaluation.demo.summary import format_summary

    argv = sys.argv[1:] if arguments is None else arguments
    config = parse(DemoConfig, argv, program="w2c demo")
    directory = _directory(config.run_directory, "demo")
    configure_logs("demo", "info", str(directory))
    options = RunOptions(directory, config.seed, config.lock_step, quiet=not config.verbose)
    logging.getLogger("w2c.demo").info("starting every process; their logs: %s", directory)
    summary = run_scenario(options)
    print(format_summary(summary))
    print(f"pictures             {', '.join(sorted(p.name for p in directory.glob('*.jpg')))}")
    print(f"all of it            {directory}")
    if config.json:
        Path(config.json).write_text(json.dumps(summary, indent=2) + "\n")
    return 1 if summary["problem"] else 0


class BenchConfig(msgspec.Struct, frozen=True, kw_only=True):
    """The demo in lock step on random layouts."""

    seeds: SeedCount = 5
    """How many layouts."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of the first layout."""
    run_directory: str = ""
    """Where everything goes; empty = runs/<date and time>-bench."""
    json: str = ""
    """Write the results to this file."""


def bench(arguments: list[str] | None = None) -> int:
    """Run the demo on each layout. Exit status 0 when all succeeded."""
    from w2c_evaluation.demo.run import RunOptions, run_scenario
    from w2c_evaluation.results import make_results, row, write_results

    config = parse(BenchConfig, arguments or [], program="w2c bench demo")
    directory = _directory(config.run_directory, "bench")
    configure_logs("bench", "info", str(directory))
    summaries: list[dict[str, Any]] = []
    for seed in range(config.seed, config.seed + config.seeds):
        options = RunOptions(directory / f"seed-{seed}", seed, lock_step=True, quiet=True)
        summaries.append(run_scenario(options))
        problem = summaries[-1]["problem"]
        print(f"seed {seed}: {problem or 'succeeded'}", flush=True)
    good = [summary for summary in summaries if not summary["problem"]]
    print(f"{len(good)} of {len(summaries)} succeeded")
    seconds = [turn["seconds"] for summary in summaries for turn in summary["turns"]]
    results = make_results(
        "demo",
        config.seed,
        [
            row("a", "succeeded", [float(len(good))], "count", n=len(summaries)),
            row(
                "a", "falls", [float(sum(s["fell"] for s in summaries))], "count", n=len(summaries)
            ),
            row("a", "hand_force", [s["hand_force_N"] for s in good], "N"),
            row("a", "end_effector_error", [s["end_effector_error_mm"] for s in good], "mm"),
            row("a", "say_to_answer", seconds, "s"),
        ],
    )
    write_results(results, Path(config.json) if config.json else directory / "results.json")
    return 0 if len(good) == len(summaries) else 1


def _directory(chosen: str, kind: str) -> Path:
    path = Path(chosen) if chosen else Path("runs") / f"{time.strftime('%Y-%m-%d_%H-%M-%S')}-{kind}"
    path.mkdir(parents=True, exist_ok=True)
    return path.resolve()
