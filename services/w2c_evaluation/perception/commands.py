"""`w2c bench perception`."""

import time
from pathlib import Path
from typing import Annotated

import msgspec

from w2c.config import parse
from w2c_evaluation.perception.report import format_table, make_rows, missed
from w2c_evaluation.perception.sensors import SensorErrors
from w2c_evaluation.perception.trial import FIRST_SCENE, SceneResult, run_scene
from w2c_evaluation.pool import ResultFile, run_all
from w2c_evaluation.results import make_results, write_results


class PerceptionBenchConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Random pixels of random scenes, lifted from noisy depth and angles, against the truth."""

    count: Annotated[int, msgspec.Meta(ge=1, le=100_000)] = 500
    """Pixels in all, rounded up to whole scenes."""
    pixels: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 20
    """Pixels of one scene."""
    seed: Annotated[int, msgspec.Meta(ge=0, le=99_999)] = 0
    """The scenes are those from 900000 + seed on."""
    workers: Annotated[int, msgspec.Meta(ge=0, le=1024)] = 0
    """Processes; 0 = one a core."""
    pictures: str = ""
    """Keep the exact pictures in this directory, and use those that are there; empty = do not."""
    run_directory: str = ""
    """Where the results go; empty = runs/<date and time>-perception."""
    resume: bool = False
    """Go on with what the run directory has already."""
    json: str = ""
    """Write the results to this file; empty = results.json in the run directory."""


def bench(arguments: list[str] | None = None) -> int:
    """Lift the pixels and print the table. Exit status 1 when a target is missed."""
    config = parse(PerceptionBenchConfig, arguments or [], program="w2c bench perception")
    directory = Path(
        config.run_directory or f"runs/{time.strftime('%Y-%m-%d_%H-%M-%S')}-perception"
    )
    question = {"seed": config.seed, "pixels": config.pixels}
    file = ResultFile(directory / "perception.jsonl", question, SceneResult)
    results = {result.scene: result for result in file.start(resume=config.resume)}
    first = FIRST_SCENE + config.seed
    scenes = [first + number for number in range(-(-config.count // config.pixels))]
    tasks = [(scene, config.pixels) for scene in scenes if scene not in results]
    errors = SensorErrors()
    for result in run_all(
        run_scene,
        [(scene, count, config.pictures, errors) for scene, count in tasks],
        workers=config.workers,
        title="scenes",
    ):
        file.add(result)
        results[result.scene] = result
    rows = make_rows([results[scene] for scene in scenes])
    document = make_results("perception", config.seed, rows)
    write_results(document, Path(config.json) if config.json else directory / "results.json")
    print(format_table(document))
    complaints = missed(rows)
    for complaint in complaints:
        print(f"target missed: {complaint}")
    print(f"\nall of it: {directory}")
    return 1 if complaints else 0
