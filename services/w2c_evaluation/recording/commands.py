"""`w2c bench recording`."""

import shutil
import sys
import tempfile
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np

from w2c.config import parse
from w2c.library import library
from w2c_evaluation.recording.killed import Killed, kill_session
from w2c_evaluation.results import make_results, results_table, row, write_results

LONGEST_LOSS_S = 1.0
"""What a killed recorder may lose [s]"""


class RecordingBenchConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Record noise at the rates of a robot, seek in it, replay it, and kill recorders."""

    seconds: Annotated[float, msgspec.Meta(ge=1, le=3600)] = 4.0
    """Of each recording. The disk needs this times the sum of the rates."""
    rates: tuple[float, ...] = (15.0, 70.0)
    """Of the messages [MB/s]: pictures as JPEG, pictures as they are."""
    kills: Annotated[int, msgspec.Meta(ge=0, le=1000)] = 2
    """Recorders to kill at random moments."""
    demo_kills: Annotated[int, msgspec.Meta(ge=0, le=1000)] = 0
    """Whole demos (`w2c demo`) to kill at random moments, each with all its processes."""
    demo_seconds: Annotated[float, msgspec.Meta(ge=0, le=3600)] = 30.0
    """The latest moment, from when a demo begins to record [s]; it must not have ended by then."""
    directory: str = ""
    """For the recordings, on the disk that is to be measured; empty = the temporary one. They are
    removed."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of the instants to seek and to kill at."""
    json: str = ""
    """Write the results to this file."""


def bench(arguments: list[str] | None = None) -> int:
    """Measure and print the table. Exit status 1 where more was lost than may be."""
    config = parse(RecordingBenchConfig, arguments or [], program="w2c bench recording")
    with tempfile.TemporaryDirectory(dir=config.directory or None) as directory:
        figures = library("recording_costs")(
            Path(directory), config.rates, config.seconds, config.kills, config.seed
        )
        rows = [row(one.case, one.metric, one.values, one.unit) for one in figures]
        rows += _demo_rows(Path(directory), config)
    results = make_results("recording", config.seed, rows)
    if config.json:
        write_results(results, Path(config.json))
    print(results_table(results))
    over = over_budget(rows)
    for line in over:
        print(line)
    return 1 if over else 0


def _demo_rows(directory: Path, config: RecordingBenchConfig) -> list[dict[str, Any]]:
    """Kill demos, one after the other; return what was lost."""
    rng = np.random.default_rng(config.seed)
    kills: list[Killed] = []
    for number in range(config.demo_kills):
        run_directory = directory / f"demo-{number}"
        command = [
            *(sys.executable, "-m", "w2c.cli", "demo"),
            *("--run-directory", str(run_directory), "--seed", str(config.seed + number)),
        ]
        found = kill_session(command, run_directory, float(rng.uniform(0.0, config.demo_seconds)))
        print(
            f"demo {number}: {found.messages} messages; the last came {found.lost_s:.2f} s before "
            f"the kill, after silences of {found.silence_s:.2f} s at most",
            flush=True,
        )
        kills.append(found)
        shutil.rmtree(run_directory)
    if not kills:
        return []
    case = "kill -9 of the demo"
    return [
        row(case, "lost_time_at_most", [one.lost_s for one in kills], "s"),
        row(case, "worst_lost_time", [max(one.surely_lost_s for one in kills)], "s"),
    ]


def over_budget(rows: list[dict[str, Any]]) -> list[str]:
    """Return what exceeds the budget, in words."""
    found = []
    for one in rows:
        if one["metric"] == "lost" and one["value"] > 0:
            found.append(
                f"{one['case']}: {one['value']:g} messages lost, budget 0: the disk is too slow, "
                "or --queue-size of the recorder too small"
            )
        if one["metric"] == "worst_lost_time" and one["value"] > LONGEST_LOSS_S:
            found.append(f"{one['case']}: {one['value']:.2f} s lost, budget {LONGEST_LOSS_S:g} s")
    return found
