"""`w2c bench pushes`."""

import time
from pathlib import Path
from typing import Annotated

import msgspec

from w2c.config import parse
from w2c.errors import ConfigError
from w2c_evaluation.pool import ResultFile, run_all
from w2c_evaluation.pushes.cases import PushResult, all_cases
from w2c_evaluation.pushes.report import draw_pushes, format_table, make_rows
from w2c_evaluation.pushes.trial import run_push
from w2c_evaluation.results import make_results, origin, write_results


class PushesConfig(msgspec.Struct, frozen=True, kw_only=True):
    """A hand pushes on a table and on a wall: how exactly, and what makes the robot fall?"""

    trials: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 3
    """Places on the surface, for each case."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of the places."""
    only: str = ""
    """Run the cases whose name holds this; empty = all."""
    workers: Annotated[int, msgspec.Meta(ge=0, le=1024)] = 0
    """Processes; 0 = one a core."""
    run_directory: str = ""
    """Where the trials go; empty = runs/<date and time>-pushes."""
    resume: bool = False
    """Go on with what the run directory has already."""
    json: str = ""
    """Write the results to this file; empty = results.json in the run directory."""
    image: str = ""
    """Write the plot to this PNG; empty = pushes.png in the run directory."""
    table: str = ""
    """Write the table to this Markdown file; empty = table.md in the run directory."""


def bench(arguments: list[str] | None = None) -> int:
    """Run the study. Exit status 0 when nothing fell."""
    config = parse(PushesConfig, arguments or [], program="w2c bench pushes")
    directory = Path(config.run_directory or f"runs/{time.strftime('%Y-%m-%d_%H-%M-%S')}-pushes")
    cases = [case for case in all_cases() if config.only in case.name]
    if not cases:
        known = ", ".join(case.name for case in all_cases())
        raise ConfigError(f"no case has '{config.only}' in its name; known: {known}")
    file = ResultFile(directory / "pushes.jsonl", {"seed": config.seed}, PushResult)
    results = {(r.case.name, r.trial): r for r in file.start(resume=config.resume)}
    wanted = [(case, trial) for trial in range(config.trials) for case in cases]
    tasks = [
        (case, trial, config.seed) for case, trial in wanted if (case.name, trial) not in results
    ]
    for result in run_all(run_push, tasks, workers=config.workers, title="pushes"):
        file.add(result)
        results[result.case.name, result.trial] = result
    ordered = [results[case.name, trial] for case, trial in wanted]
    document = make_results("pushes", config.seed, make_rows(ordered))
    write_results(document, Path(config.json) if config.json else directory / "results.json")
    table = f"# Pushes of the right hand\n\n{format_table(ordered)}\n\n{origin(document)}\n"
    (Path(config.table) if config.table else directory / "table.md").write_text(table)
    print(table)
    draw_pushes(ordered, Path(config.image) if config.image else directory / "pushes.png")
    print(f"\nall of it: {directory}")
    return 1 if any(result.fell for result in ordered) else 0
