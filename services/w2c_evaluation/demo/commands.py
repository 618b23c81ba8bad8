"""`w2c demo`, and `w2c bench demo`."""

import json
import logging
import sys
import time
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec

from w2c.config import parse
from w2c.logs import configure_logs

FIRST = "a"
"""Its demo plays in real time, says the same words each time and shows the console"""
SeedCount = Annotated[int, msgspec.Meta(ge=1, le=10_000)]


class DemoConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Play a story of the paper in the simulator, with every process of the system."""

    scene: str = "a"
    """What is played: a, b, c, d (the paper's), e (a hand on a wall, a foot lifted), random."""
    boxes: Literal["model", "truth"] = "model"
    """Who finds things in pictures: the grounding service, or the simulator's truth."""
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
    """Play it. Exit status 0 when every hand came where it was sent, and nothing fell.

    Raises:
        ConfigError: there is no such scene, or no layout of this seed.
    """
    argv = sys.argv[1:] if arguments is None else arguments
    config = parse(DemoConfig, argv, program="w2c demo")
    if config.scene != FIRST or config.boxes == "truth":
        return _play_story(config)
    from w2c_evaluation.demo.run import RunOptions, run_scenario
    from w2c_evaluation.demo.summary import format_summary

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


def _play_story(config: DemoConfig) -> int:
    """Play a scene with an operator who looks, corrects and confirms; in lock step."""
    from w2c_evaluation.demo.stories import find_story
    from w2c_evaluation.demo.told import format_story, make_summary
    from w2c_evaluation.scenarios.film import make_strip
    from w2c_evaluation.scenarios.run import PICTURES, RECORDING, RunOptions, run_scenario

    story = find_story(config.scene)
    directory = _directory(config.run_directory, f"demo-{config.scene}")
    configure_logs("demo", "info", str(directory))
    log = logging.getLogger("w2c.demo")
    log.info("%s, in lock step; the operator corrects what is not right", story.experiment.title)
    log.info("starting every process; their logs: %s", directory)
    played = directory / "played"  # emptied by the run
    options = RunOptions(played, config.boxes, "model", keep=True, afterwards=story.afterwards)
    result = run_scenario(story.experiment, config.seed, options)
    recording = str(played / RECORDING)
    summary = make_summary(result, config.boxes, recording)
    text = json.dumps(summary, indent=2) + "\n"
    (directory / "summary.json").write_text(text)
    if config.json:
        Path(config.json).write_text(text)
    make_strip(played / PICTURES, directory / "story.jpg")
    done = "" if story.afterwards is None else story.afterwards.title
    print(format_story(result, config.boxes, recording, done))
    print(f"pictures             {directory / 'story.jpg'}")
    print(f"all of it            {directory}")
    return 0 if result.succeeded else 1


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
