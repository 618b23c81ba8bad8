"""`w2c benchmark make|check`."""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

import msgspec
import tyro
from rich.console import Console
from rich.progress import track

from w2c.config import fail
from w2c.errors import ConfigError, W2CError
from w2c.extras import needs_extra
from w2c.library import library

SIZE = (1280, 720)
PROGRAM = "w2c benchmark"


class Make(msgspec.Struct, frozen=True, kw_only=True):
    """Make a benchmark in the paper's format: pictures, prompts and masks of the accepted area.

    Half of the prompts name a place on a thing, half one relative to things. The pictures are
    rendered, from scenes that no training may use; the masks come from the geometry. The exit
    status is 1 where the benchmark misses a limit that keeps it from being easy.
    """

    out: Path
    """Folder, made if it is missing; it must be empty."""
    seed: Annotated[int, msgspec.Meta(ge=0, le=1_000_000)] = 0
    """The same seed gives the same prompts and masks; another one shows other scenes."""
    count: Annotated[int, msgspec.Meta(ge=2, le=1000)] = 78
    """Number of pictures."""
    unseen: bool = False
    """Ask for things of kinds, materials and colours that no training shows; else for none of
    them, though they stand among the others."""


class Check(msgspec.Struct, frozen=True, kw_only=True):
    """Say what is wrong with a folder of pictures, prompts and masks. Exit status 1 for faults."""

    directory: tyro.conf.Positional[Path]
    """The folder; docs/reference/benchmark.md says what it shall hold."""


def main(arguments: list[str] | None = None) -> int:
    """Run the verb. Exit status: 0 done, 1 missed or faulty, 2 usage."""
    argv = sys.argv[1:] if arguments is None else arguments
    commands: dict[str, Callable[..., Any]] = {"make": Make, "check": Check}
    chosen = tyro.extras.subcommand_cli_from_dict(commands, prog=PROGRAM, args=argv)
    try:
        checked = msgspec.convert(msgspec.structs.asdict(chosen), type(chosen))
        return _make(checked) if isinstance(checked, Make) else _check(checked)
    except msgspec.ValidationError as error:
        return fail(ConfigError(f"{error}"), PROGRAM)
    except W2CError as error:
        return fail(error, PROGRAM)


def _make(options: Make) -> int:
    with needs_extra("sim-robot"):
        pictures = library("true_pictures")(*SIZE)
    from w2c_evaluation.benchmark.make import Folder, fill

    console = Console(stderr=True)
    folder = Folder(options.out, SIZE)
    try:
        for made in track(
            fill(pictures, options.seed, options.count, unseen=options.unseen),
            "pictures",
            total=options.count,
            console=console,
            disable=not console.is_terminal,
        ):
            folder.add(made)
    finally:
        pictures.close()
    manifest = folder.finish(options.seed)
    print(describe(manifest.figures))
    for complaint in manifest.missed:
        print(f"limit missed: {complaint}")
    print(f"{options.count} pictures with prompts and masks: {options.out}")
    return 1 if manifest.missed else 0


def describe(figures: Any) -> str:
    """Return the figures of a benchmark for people."""
    hits = ", ".join(f"{name} {value:.3f}" for name, value in figures.random.items())
    ways = ", ".join(f"{name} {count}" for name, count in figures.namings.items())
    return "\n".join(
        (
            f"{figures.absolute} absolute, {figures.relative} relative; random points hit: {hits}",
            f"{figures.avoiding:.0%} avoid the usual name ({ways})",
            f"{figures.pairs:.0%} of the pictures hold two of a kind that something tells apart, "
            f"{figures.asked_pairs:.0%} of the prompts are about one of them",
            f"{figures.distractors} distractors or more, {figures.distractors_mean:.1f} on average",
            f"{figures.outdoors:.0%} look outdoors, {figures.feet:.0%} are for a foot, "
            f"{len(figures.verbs)} verbs, {figures.held_out:.0%} about what no training shows",
        )
    )


def _print_hardness(items: Sequence[Any]) -> None:
    """Print how often a point by chance hits, and the limits that a folder of `make` misses."""
    from w2c_evaluation.benchmark.figures import figures_of, mean, missed
    from w2c_evaluation.benchmark.record import POSITIONS

    records = [item.record for item in items]
    shares = [float(item.accepted().mean()) for item in items]
    of = {
        name: [s for r, s in zip(records, shares, strict=True) if r.position == name]
        for name in POSITIONS
    }
    hits = ", ".join(f"{name} {mean(found):.3f}" for name, found in of.items() if found)
    print(f"random points hit: {hits}, overall {mean(shares):.3f}")
    if all(record.origin is not None for record in records):
        for complaint in missed(figures_of(records, shares)):
            print(f"limit missed: {complaint}")


def _check(options: Check) -> int:
    from w2c_evaluation.benchmark.dataset import read

    items, faults = read(options.directory)
    for fault in faults:
        print(fault)
    if items:
        _print_hardness(items)
    print(f"{len(items)} sound, {len(faults)} faults: {options.directory}")
    return 1 if faults else 0
