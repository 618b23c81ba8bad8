"""`w2c dialogue corpus`: write the corpus to files."""

import argparse
from pathlib import Path

import msgspec
import numpy as np

from w2c_dialogue.corpus.generate import examples

HELD_OUT_COUNT = 1000


def corpus(arguments: list[str]) -> int:
    """Write `train.jsonl` and `heldout.jsonl`, one example a line. Returns the exit status."""
    parser = argparse.ArgumentParser(prog="w2c dialogue corpus", description=corpus.__doc__)
    parser.add_argument(
        "--out", type=Path, required=True, help="folder to write to; made if it is not there"
    )
    parser.add_argument("--count", type=int, default=300_000, help="lines of train.jsonl")
    parser.add_argument(
        "--held-out", type=int, default=HELD_OUT_COUNT, help="lines of heldout.jsonl"
    )
    parser.add_argument("--seed", type=int, default=0, help="same seed, same files")
    chosen = parser.parse_args(arguments)
    if chosen.count < 1 or chosen.held_out < 1 or chosen.seed < 0:
        parser.error("--count and --held-out must be at least 1, --seed at least 0")
    try:
        chosen.out.mkdir(parents=True, exist_ok=True)
        for name, count, held_out in (
            ("train", chosen.count, False),
            ("heldout", chosen.held_out, True),
        ):
            path = chosen.out / f"{name}.jsonl"
            _write(path, count, np.random.default_rng([chosen.seed, held_out]), held_out=held_out)
            print(f"{path}: {count} lines")
    except OSError as error:
        print(f"w2c dialogue corpus: cannot write to {chosen.out}: {error}")
        return 1
    return 0


def _write(path: Path, count: int, generator: np.random.Generator, *, held_out: bool) -> None:
    encoder = msgspec.json.Encoder()
    with path.open("wb") as file:
        for example in examples(generator, count, held_out=held_out):
            file.write(encoder.encode(example) + b"\n")
