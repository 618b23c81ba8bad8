"""`w2c train language`: from a corpus to a GGUF file."""

import argparse
import json
import os
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from w2c.config import fail
from w2c.errors import ConfigError, W2CError
from w2c.extras import needs_extra
from w2c_llm.train.interruption import interruptible
from w2c_llm.train.plan import Shape, TrainingPlan, TrainingResult

PROGRAM = "w2c train language"
STOPPED = 1
_MOST_THREADS = 8
"""The matrices are too small for more"""


def train(arguments: list[str] | None = None) -> int:
    """Train the embedded language model. Returns the exit status, 1 when it was stopped."""
    options = _parser().parse_args(arguments)
    try:
        plan = _plan(options)
        plan.check()
        with needs_extra("train"):
            from w2c_llm.train.run import Run
        with interruptible() as stopped:
            result = Run(plan, lambda line: print(line, flush=True))(stopped)
        if result is None:
            return STOPPED
        if options.json is not None:
            options.json.write_text(json.dumps(_document(result), indent=1) + "\n")
    except W2CError as error:
        return fail(error, PROGRAM)
    except OSError as error:
        return fail(ConfigError(f"{error.filename}: {error.strerror}"), PROGRAM)
    print(f"model: {result.model_path} ({result.megabytes:.1f} MB); card: {result.card_path}")
    return 0


def _plan(options: argparse.Namespace) -> TrainingPlan:
    return TrainingPlan(
        corpus=options.corpus,
        heldout=options.heldout,
        output=options.out,
        minutes=options.minutes,
        steps=options.steps,
        begin_with=tuple(options.from_),
        dialogues=options.with_,
        dialogues_share=options.with_share,
        shape=Shape(
            options.layers,
            options.width,
            options.feed_forward,
            options.vocabulary,
            options.begin_layers,
        ),
        batch=options.batch,
        peak_rate=options.rate,
        prompt_weight=options.prompt_weight,
        dropout=options.dropout,
        compiled=options.compile,
        threads=options.threads,
        weights=options.weights,
        seed=options.seed,
        resume=options.resume,
    )


def _document(result: TrainingResult) -> dict[str, Any]:
    fields = asdict(result)
    rows = [
        {"case": task, "metric": "exact_match", "value": right / total, "unit": "rate", "n": total}
        for task, (right, total) in fields["exact_match"].items()
    ]
    for name, unit in (("minutes", "min"), ("examples_seen", ""), ("megabytes", "MB")):
        rows.append({"case": "run", "metric": name, "value": fields[name], "unit": unit, "n": 1})
    return {"benchmark": "train.language", "seed": result.seed, "rows": rows}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=PROGRAM,
        description="Train the language model that is shipped, or go on from it. Ctrl-C or SIGTERM "
        "ends a run at its next step; --resume goes on.",
    )
    parser.add_argument("--corpus", type=Path, required=True, help="JSONL of chats with answers")
    parser.add_argument("--heldout", type=Path, required=True, help="the same, never trained on")
    parser.add_argument("--out", type=Path, required=True, help="folder for checkpoint and model")
    parser.add_argument(
        "--minutes", type=float, default=60.0, help="wall time of the whole command (default 60)"
    )
    parser.add_argument(
        "--steps",
        type=int,
        help="end after so many steps instead: the same result for the same seed, machine, threads",
    )
    parser.add_argument(
        "--from",
        dest="from_",
        type=Path,
        nargs="+",
        default=(),
        metavar="FILE",
        help="begin with the weights and the tokenizer of a GGUF file or a checkpoint; of several, "
        "with the mean of their weights (with --layers also of some that have fewer layers)",
    )
    parser.add_argument(
        "--with",
        dest="with_",
        type=Path,
        metavar="DATASET",
        help="JSONL of your own dialogues, mixed into every epoch",
    )
    parser.add_argument(
        "--with-share", type=float, default=0.2, help="their share of all examples (default 0.2)"
    )
    parser.add_argument(
        "--layers",
        type=int,
        help="default 6, or those of --from; more than those add layers that change nothing yet",
    )
    parser.add_argument(
        "--begin-layers",
        type=int,
        help="layers at first; the network grows to --layers when a third of the time is spent",
    )
    parser.add_argument("--width", type=int, help="default 256, or that of --from")
    parser.add_argument("--feed-forward", type=int, help="default 768, or that of --from")
    parser.add_argument(
        "--vocabulary", type=int, help="tokens of the BPE; default 4096, or those of --from"
    )
    parser.add_argument("--batch", type=int, default=96, help="examples a step (default 96)")
    parser.add_argument(
        "--rate", type=float, help="peak learning rate; default 0.005, with --from 0.001"
    )
    parser.add_argument(
        "--prompt-weight",
        type=float,
        default=0.0,
        help="of a prompt's token in the loss (default 0: faster, and no worse)",
    )
    parser.add_argument(
        "--dropout",
        type=float,
        default=0.0,
        help="share of what each block adds that is left out while training (default 0)",
    )
    parser.add_argument(
        "--compile",
        action="store_true",
        help="turn the network into machine code first (needs a C++ compiler): half a minute, then "
        "a step takes a fifth less time",
    )
    cores = len(os.sched_getaffinity(0))
    parser.add_argument(
        "--threads", type=int, default=min(cores, _MOST_THREADS), help="default: all cores, up to 8"
    )
    parser.add_argument("--weights", choices=("f32", "f16", "q8_0"), default="q8_0")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--resume", action="store_true", help="go on from the checkpoint in --out")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the result here")
    return parser


if __name__ == "__main__":
    sys.exit(train())
