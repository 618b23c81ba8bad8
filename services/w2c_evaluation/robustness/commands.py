"""`w2c bench robustness`."""

import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated

import msgspec

from w2c.config import parse
from w2c_evaluation.pool import ResultFile, run_all
from w2c_evaluation.results import make_results, origin, write_results
from w2c_evaluation.robustness.grid import (
    MASSES,
    MODES,
    SPEEDS,
    Cell,
    Mode,
    Target,
    TrialResult,
    cells,
)
from w2c_evaluation.robustness.report import draw_heat_map, format_tables, make_rows
from w2c_evaluation.robustness.targets import find_target
from w2c_evaluation.robustness.trial import run_trial


class RobustnessConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Far reaches with an unknown mass in the hand, in the simulator: who falls?"""

    trials: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 10
    """In each cell of speed, mass and mode."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of the directions."""
    stiffness: Annotated[float, msgspec.Meta(ge=0.05, le=20.0)] = 1.0
    """True joint stiffness over the one that the controller knows."""
    modes: tuple[Mode, ...] = MODES
    """Of force control."""
    speeds: tuple[float, ...] = SPEEDS
    """Commanded top speeds of the hand [m/s]."""
    masses: tuple[float, ...] = MASSES
    """In the hand [kg]."""
    workers: Annotated[int, msgspec.Meta(ge=0, le=1024)] = 0
    """Processes; 0 = one a core."""
    run_directory: str = ""
    """Where the trials go; empty = runs/<date and time>-robustness."""
    resume: bool = False
    """Go on with what the run directory has already."""
    json: str = ""
    """Write the results to this file; empty = results.json in the run directory."""
    image: str = ""
    """Write the heat map to this PNG; empty = heat_map.png in the run directory."""
    table: str = ""
    """Write the tables to this Markdown file; empty = tables.md in the run directory."""


def bench(arguments: list[str] | None = None) -> int:
    """Run the study. Exit status 0 when every trial was run."""
    config = parse(RobustnessConfig, arguments or [], program="w2c bench robustness")
    directory = Path(
        config.run_directory or f"runs/{time.strftime('%Y-%m-%d_%H-%M-%S')}-robustness"
    )
    wanted = list(cells(config.modes, config.speeds, config.masses, config.trials))
    targets = _targets(config, directory, wanted)
    results = _trials(config, directory, wanted, targets)
    document = make_results("robustness", config.seed, make_rows(results))
    document["stiffness"] = config.stiffness
    write_results(document, Path(config.json) if config.json else directory / "results.json")
    draw_heat_map(results, Path(config.image) if config.image else directory / "heat_map.png")
    title = f"# Far reaches with an unknown mass, stiffness x{config.stiffness:g}"
    tables = f"{title}\n\n{format_tables(results)}\n\n{origin(document)}\n"
    (Path(config.table) if config.table else directory / "tables.md").write_text(tables)
    print(tables)
    print(f"\nall of it: {directory}")
    return 0


def _targets(
    config: RobustnessConfig, directory: Path, wanted: Iterable[Cell]
) -> dict[tuple[int, float], Target]:
    """Return the target of each trial and mass, found once."""
    file = ResultFile(directory / "targets.jsonl", {"seed": config.seed}, Target)
    targets = {(t.trial, t.mass): t for t in file.start(resume=config.resume)}
    needed = dict.fromkeys((cell.trial, cell.mass) for cell in wanted)
    missing = [(trial, mass, config.seed) for trial, mass in needed if (trial, mass) not in targets]
    for target in run_all(find_target, missing, workers=config.workers, title="farthest points"):
        file.add(target)
        targets[target.trial, target.mass] = target
    return targets


def _trials(
    config: RobustnessConfig,
    directory: Path,
    wanted: Sequence[Cell],
    targets: dict[tuple[int, float], Target],
) -> list[TrialResult]:
    """Return the results of all wanted trials; runs those that are missing."""
    question = {"seed": config.seed, "stiffness": config.stiffness}
    file = ResultFile(directory / "trials.jsonl", question, TrialResult)
    results = {result.cell: result for result in file.start(resume=config.resume)}
    tasks = [
        (cell, targets[cell.trial, cell.mass], config.stiffness)
        for cell in wanted
        if cell not in results
    ]
    for result in run_all(run_trial, tasks, workers=config.workers, title="trials"):
        file.add(result)
        results[result.cell] = result
    return [results[cell] for cell in wanted]
