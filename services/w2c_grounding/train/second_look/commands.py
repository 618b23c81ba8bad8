"""`w2c train second-look`: teach a checkpoint to look at regions from near."""

import sys
from pathlib import Path
from typing import Annotated

import msgspec

from w2c.config import fail, parse
from w2c.errors import W2CError
from w2c.extras import needs_extra

PROGRAM = "w2c train second-look"
STOPPED = 1


class SecondLookConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Train the second look of a vision model on pictures of `w2c scenes render`.

    Writes OUT/checkpoint (that of --checkpoint with the second look and a new threshold),
    OUT/scores.json and, every five minutes, OUT/state.pt for --resume. One picture in twenty of
    --data is not trained on: the threshold is calibrated there. The things of 10,000 pictures take
    1.6 GB of memory. Ctrl-C or SIGTERM ends a training at its next step.
    """

    data: str
    """Directory of pictures to train on."""
    out: str
    """Directory for the results."""
    checkpoint: str
    """A checkpoint directory of `w2c train grounding`; the second look that it has, if any, is gone
    on from."""
    minutes: Annotated[float, msgspec.Meta(gt=0)] = 30.0
    """Wall time of the whole command, earlier parts of a resumed one included."""
    steps: Annotated[int, msgspec.Meta(ge=0)] = 0
    """End after so many steps instead: the same result for the same seed, machine and threads."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of weights, order, questions and changes to pictures."""
    threads: Annotated[int, msgspec.Meta(ge=1, le=256)] = 2
    """CPU threads."""
    rate: Annotated[float, msgspec.Meta(gt=0, lt=1)] = 2e-3
    """Highest learning rate."""
    name: str = ""
    """Of the model, in its card and its replies; default that of --checkpoint."""
    resume: bool = False
    """Go on from OUT/state.pt."""


def train(arguments: list[str] | None = None) -> int:
    """Run the verb. Exit status: 0 done, 1 stopped or failed, 2 usage."""
    argv = sys.argv[1:] if arguments is None else arguments
    config = parse(SecondLookConfig, argv, program=PROGRAM)
    with needs_extra("train"):
        from w2c.clock import RealClock
        from w2c_grounding.train.interruption import interruptible
        from w2c_grounding.train.second_look.run import Task, run
    task = Task(
        data=Path(config.data),
        checkpoint=Path(config.checkpoint),
        out=Path(config.out),
        minutes=config.minutes,
        steps=config.steps,
        seed=config.seed,
        threads=config.threads,
        rate=config.rate,
        name=config.name,
        resume=config.resume,
    )
    try:
        with interruptible() as stopped:
            scores = run(task, RealClock(), lambda line: print(line, flush=True), stopped)
    except W2CError as error:
        return fail(error, PROGRAM)
    if scores is None:
        print(
            f"stopped; go on with: {PROGRAM} --data {config.data} --out {config.out} "
            f"--checkpoint {config.checkpoint} --resume"
        )
        return STOPPED
    print(msgspec.json.format(msgspec.json.encode(scores), indent=1).decode())
    return 0
