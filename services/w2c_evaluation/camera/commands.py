"""`w2c bench camera`."""

from pathlib import Path
from typing import Annotated

import msgspec

from w2c.config import parse
from w2c.library import library
from w2c_evaluation.results import make_results, results_table, row, write_results


class CameraBenchConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Draw and encode pictures of scene (a): processor time of all threads, bytes on the wire."""

    count: Annotated[int, msgspec.Meta(ge=1, le=10_000)] = 30
    """Pictures of each case."""
    width: Annotated[int, msgspec.Meta(ge=64, le=1920)] = 1280
    """[px]"""
    height: Annotated[int, msgspec.Meta(ge=64, le=1080)] = 720
    """[px]"""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of where the head looks."""
    json: str = ""
    """Write the results to this file."""


def bench(arguments: list[str] | None = None) -> int:
    """Measure and print the table. Exit status 0."""
    config = parse(CameraBenchConfig, arguments or [], program="w2c bench camera")
    costs = library("camera_costs")((config.width, config.height), config.count, config.seed)
    rows = []
    for case in dict.fromkeys(cost.case for cost in costs):
        of_case = [cost for cost in costs if cost.case == case]
        rows.append(row(case, "cpu_ms", [cost.cpu_ms for cost in of_case], "ms"))
        rows.append(row(case, "bytes", [float(cost.bytes) for cost in of_case], "bytes"))
    results = make_results("camera", config.seed, rows)
    if config.json:
        write_results(results, Path(config.json))
    print(results_table(results))
    return 0
