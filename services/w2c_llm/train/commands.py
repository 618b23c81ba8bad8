"""`w2c train language`: from a corpus to a GGUF file."""

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from w2c.config import fail
from w2c.errors import W2CError
from w2c.extras import needs_extra

PROGRAM = "w2c train language"


def train(arguments: list[str] | None = None) -> int:
    """Train the embedded language model. Returns the exit status."""
    options = _parser().parse_args(arguments)
    try:
        with needs_extra("train"):
            from w2c_llm.train.run import TrainingPlan, run
        plan = TrainingPlan(
            corpus=options.corpus,
            heldout=options.heldout,
            output=options.out,
            minutes=options.minutes,
            steps=options.steps,
            vocabulary=options.vocabulary,
            layers=options.layers,
            width=options.width,
            feed_forward=options.feed_forward,
            batch=options.batch,
            peak_rate=options.rate,
            prompt_weight=options.prompt_weight,
            threads=options.threads,
            weights=options.weights,
            seed=options.seed,
            resume=options.resume,
        )
        result = run(plan, lambda line: print(line, flush=True))
    except W2CError as error:
        return fail(error, PROGRAM)
    if options.json is not None:
        options.json.write_text(json.dumps(_rows(asdict(result)), indent=1) + "\n")
    print(f"model: {result.model_path} ({result.megabytes:.1f} MB)")
    return 0


def _rows(result: dict[str, Any]) -> dict[str, Any]:
    rows = [
        {"case": task, "metric": "exact_match", "value": right / total, "unit": "rate", "n": total}
        for task, (right, total) in result["exact_match"].items()
    ]
    return {"benchmark": "train.language", "seed": result["seed"], "rows": rows}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=PROGRAM, description=__doc__)
    parser.add_argument("--corpus", type=Path, required=True, help="JSONL of chats with answers")
    parser.add_argument("--heldout", type=Path, required=True, help="the same, never trained on")
    parser.add_argument("--out", type=Path, required=True, help="folder for checkpoint and model")
    parser.add_argument("--minutes", type=float, default=40.0, help="training time in all")
    parser.add_argument("--steps", type=int, help="end after so many steps instead")
    parser.add_argument("--vocabulary", type=int, default=2048, help="tokens of the BPE")
    parser.add_argument("--layers", type=int, default=4)
    parser.add_argument("--width", type=int, default=256)
    parser.add_argument("--feed-forward", type=int, default=704)
    parser.add_argument("--batch", type=int, default=48, help="examples a step")
    parser.add_argument("--rate", type=float, default=2e-3, help="peak learning rate")
    parser.add_argument(
        "--prompt-weight", type=float, default=0.2, help="of a prompt's token in the loss"
    )
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--weights", choices=("f32", "f16", "q8_0"), default="q8_0")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--resume", action="store_true", help="continue from the checkpoint in --out"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the result here")
    return parser


if __name__ == "__main__":
    sys.exit(train())
