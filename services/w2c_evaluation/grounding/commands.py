"""`w2c bench grounding`."""

from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec

from w2c.config import parse
from w2c.errors import ProcessError, W2CError
from w2c.extras import needs_extra
from w2c.library import library
from w2c.workers import end_with_parent
from w2c_evaluation.grounding.report import EMBEDDED, format_table, make_rows, missed
from w2c_evaluation.results import make_results, write_results


class GroundingBenchConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Time and memory of vision models: one phrase, five phrases on a picture, five pictures.

    Each model in a process of its own, one after the other.
    """

    models: tuple[str, ...] = (EMBEDDED,)
    """`embedded`, names of `w2c ground models`, checkpoint directories."""
    family: str = ""
    """Of all of them; empty = what each checkpoint says of itself."""
    devices: tuple[str, ...] = ("cpu", "cuda")
    """What this machine does not have is left out."""
    dtype: Literal["float32", "bfloat16", "float16"] = "float32"
    """Of the weights in memory."""
    threads: Annotated[int, msgspec.Meta(ge=1, le=256)] = 2
    """CPU threads."""
    rounds: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 20
    """Of all questions; medians count."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of pictures and phrases."""
    json: str = ""
    """Write the results to this file."""


def bench(arguments: list[str] | None = None) -> int:
    """Measure and print the table.

    A model that cannot be measured leaves the others. Exit status 1 where there was one, or where
    the embedded model misses a target.

    Raises:
        W2CError: not one could be measured.
    """
    config = parse(GroundingBenchConfig, arguments or [], program="w2c bench grounding")
    with needs_extra("grounding"):
        library("grounding_costs")
    rows: list[dict[str, Any]] = []
    failures: list[W2CError] = []
    for model in config.models:
        for device in config.devices:
            print(f"{model} on {device} ...", flush=True)
            try:
                costs = _measure_alone(_question(config, model, device))
            except W2CError as error:
                failures.append(error)
                print(f"not measured: {error}", flush=True)
                continue
            if costs is not None:
                name = EMBEDDED if model == EMBEDDED else costs.name
                rows += make_rows(name if device == "cpu" else f"{name}@{device}", costs)
    if failures and not rows:
        raise failures[0]
    results = make_results("grounding", config.seed, rows)
    if config.json:
        write_results(results, Path(config.json))
    print(format_table(results))
    complaints = missed(rows)
    for complaint in complaints:
        print(f"target missed: {complaint}")
    return 1 if complaints or failures else 0


def _question(config: GroundingBenchConfig, model: str, device: str) -> dict[str, Any]:
    return {
        "model": model,
        "family": config.family,
        "device": device,
        "dtype": config.dtype,
        "threads": config.threads,
        "rounds": config.rounds,
        "seed": config.seed,
    }


def _measure_alone(question: dict[str, Any]) -> Any:
    """Return the costs of a model, measured in a new process: its peak of memory is its own.

    Raises:
        W2CError: it cannot be loaded, or its process was ended.
    """
    spawn = get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn, initializer=end_with_parent) as pool:
        try:
            return pool.submit(measure, question).result()
        except BrokenProcessPool as error:
            raise ProcessError(
                f"the process that measured {question['model']} on {question['device']} was ended, "
                "as a system does that has no memory left: end other programs, try "
                "--dtype bfloat16, or a smaller model"
            ) from error


def measure(question: dict[str, Any]) -> Any:
    """Measure in this process; None where the device is not there. Raises ModelError."""
    return library("grounding_costs")(**question)
