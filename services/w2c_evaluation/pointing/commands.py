"""`w2c evaluate grounding`: fresh scenes, every way to name what they show, and what they lack."""

import subprocess
import sys
import time
from pathlib import Path
from typing import Annotated

import msgspec

from w2c.config import parse
from w2c.errors import ProcessError
from w2c.extras import needs_extra
from w2c.library import library
from w2c_evaluation.pointing.report import ABSENT, TARGETS, format_table, make_rows
from w2c_evaluation.results import make_results, origin, write_results


class PointingConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Whether a vision model points at what is named, and at nothing where nothing is.

    Renders random scenes at 1280 x 720, and asks for every clearly visible thing by name, synonym,
    colour, material, size, part, and by what tells it from another of its kind; and for things that
    are not there. Kinds, and pairs of kind and colour or material, that training never saw are
    reported apart.
    """

    model: str = ""
    """Checkpoint directory or a name of `w2c ground models`; empty = the embedded model."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 900_000
    """First scene; below 900000 are those for training."""
    count: Annotated[int, msgspec.Meta(ge=1)] = 400
    """Scenes."""
    threads: Annotated[int, msgspec.Meta(ge=1, le=256)] = 2
    """CPU threads."""
    jobs: Annotated[int, msgspec.Meta(ge=1, le=64)] = 2
    """Processes that render."""
    run_directory: str = ""
    """Where everything goes, the pictures too; empty = runs/<date and time>-grounding. In one that
    is there, pictures that are there are kept."""
    json: str = ""
    """Write the results to this file; empty = results.json in the run directory."""


def evaluate(arguments: list[str] | None = None) -> int:
    """Render, ask and judge. Exit status 0 when every target is met.

    Raises:
        ConfigError: a flag is wrong.
        ModelError: the checkpoint cannot be used.
        ProcessError: no pictures could be rendered.
    """
    config = parse(PointingConfig, arguments or [], program="w2c evaluate grounding")
    with needs_extra("grounding"):
        score_model = library("score_grounding")
    stamp = time.strftime("%Y-%m-%d_%H-%M-%S")
    directory = Path(config.run_directory or f"runs/{stamp}-grounding").resolve()
    pictures = directory / f"scenes-{config.seed}-{config.count}"
    render(config, pictures)
    trials, threshold, name = score_model(
        config.model,
        pictures,
        seed=config.seed,
        threads=config.threads,
        report=lambda line: print(line, flush=True),
    )
    rows = make_rows(trials, threshold)
    document = make_results("grounding_hits", config.seed, rows)
    document |= {"model": name, "threshold": threshold, "scenes": config.count}
    write_results(document, Path(config.json) if config.json else directory / "results.json")
    misses = [msgspec.json.encode(trial) for trial in trials if trial.kind and not trial.peak_hits]
    (directory / "misses.jsonl").write_bytes(b"".join(line + b"\n" for line in misses))
    title = f"# {name}, threshold {threshold}, {config.count} scenes"
    text = f"{title}\n\n{format_table(rows)}\n\n{origin(document)}\n"
    (directory / "tables.md").write_text(text)
    print(f"{text}\nall of it, misses too: {directory}")
    values = {(row["case"], row["metric"]): row["value"] for row in rows}
    hit = values.get(("seen", "hit"), 0.0) >= TARGETS["hit"]
    rejected = values.get((ABSENT, "rejected"), 0.0) >= TARGETS["rejected"]
    return 0 if hit and rejected else 1


def render(config: PointingConfig, pictures: Path) -> None:
    """Render the scenes into a directory, in a process of their own. Raises ProcessError."""
    pictures.parent.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "w2c.cli", "scenes", "render", "--resume", "--no-depth"]
    command += ["--out", str(pictures), "--seed", str(config.seed), "--count", str(config.count)]
    command += ["--width", "1280", "--height", "720", "--picture", "jpg"]
    command += ["--jobs", str(config.jobs)]
    done = subprocess.run(command, check=False)
    if done.returncode:
        raise ProcessError(
            f"`w2c scenes render` ended with status {done.returncode}; see its message above, and "
            f"go on with: w2c evaluate grounding --run-directory {pictures.parent}"
        )
