"""`w2c bench language`."""

import os
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from w2c.config import parse
from w2c.extras import needs_extra
from w2c.library import library
from w2c_evaluation.language.instruction import measure_service
from w2c_evaluation.language.report import (
    EMBEDDED,
    comparison_rows,
    format_table,
    missed,
    service_rows,
)
from w2c_evaluation.results import make_results, write_results

Part = Literal["random", "embedded", "service"]


class LanguageBenchConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Time and tokens of a question, beside `create_chat_completion` of llama-cpp-python."""

    parts: tuple[Part, ...] = ("random", "embedded", "service")
    """random: a model of 0.5 B random weights and 150,000 tokens. embedded: the model of this
    repository. service: whole instructions, and the idle service's memory."""
    rounds: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 20
    """Questions of each kind to the embedded model; rounds of ten instructions: a quarter."""
    random_rounds: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 2
    """Questions of each kind to the random model, which take a quarter of a minute each."""
    threads: Annotated[int, msgspec.Meta(ge=1, le=256)] = 1
    """Threads of both; with one, times are CPU time, with more wall time."""
    cache: str = ""
    """Folder of the random model (0.7 GB); empty = words2contact in the user's cache."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of the sentences."""
    json: str = ""
    """Write the results to this file."""


def bench(arguments: list[str] | None = None) -> int:
    """Measure and print the table. Exit status 1 when a target is missed."""
    config = parse(LanguageBenchConfig, arguments or [], program="w2c bench language")
    rows = []
    with needs_extra("train"):
        if "random" in config.parts:
            path = library("random_language_model")(cache_folder(config.cache))
            rows += _compare(config, path, config.random_rounds, "")
        if "embedded" in config.parts:
            path = library("embedded_language_model")
            rows += _compare(config, path, config.rounds, EMBEDDED)
    if "service" in config.parts:
        rows += service_rows(measure_service(max(1, config.rounds // 4)))
    results = make_results("language", config.seed, rows)
    if config.json:
        write_results(results, Path(config.json))
    print(format_table(results))
    complaints = missed(rows)
    for complaint in complaints:
        print(f"target missed: {complaint}")
    return 1 if complaints else 0


def _compare(
    config: LanguageBenchConfig, path: Path, rounds: int, prefix: str
) -> list[dict[str, object]]:
    comparison = library("compare_language_calls")(
        path, rounds=rounds, threads=config.threads, seed=config.seed
    )
    return comparison_rows(comparison, prefix)


def cache_folder(name: str) -> Path:
    """Return where large files are kept that can be made again."""
    if name:
        return Path(name)
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "words2contact"
