"""`w2c train grounding`: make the embedded model from pictures."""

import sys
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import tyro

from w2c.config import fail, parse
from w2c.errors import W2CError
from w2c.extras import needs_extra
from w2c_grounding.train.plan import NAME

PROGRAM = "w2c train grounding"
STOPPED = 1


class TrainConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Train a small CLIPSeg on pictures of `w2c scenes render`.

    Writes OUT/checkpoint (what `w2c grounding --model` reads), OUT/scores.json, OUT/pictures (the
    pictures as the model reads them; may be removed afterwards) and, every five minutes,
    OUT/state.pt for --resume. One picture in twenty of --data is not trained on: the threshold is
    calibrated there. Ctrl-C or SIGTERM ends a training at its next step.
    """

    data: str
    """Directory of pictures to train on."""
    out: str
    """Directory for the results."""
    minutes: Annotated[float, msgspec.Meta(gt=0)] = 60.0
    """Wall time of the whole command, earlier parts of a resumed one included."""
    steps: Annotated[int, msgspec.Meta(ge=0)] = 0
    """End after so many steps instead: the same result for the same seed, machine and threads."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of weights, order, questions and changes to pictures."""
    threads: Annotated[int, msgspec.Meta(ge=1, le=256)] = 2
    """CPU threads."""
    rate: Annotated[float, msgspec.Meta(gt=0, lt=1)] | None = None
    """Highest learning rate; default 0.0015, with --from 0.0005."""
    begin_with: Annotated[str, tyro.conf.arg(name="from")] = ""
    """A checkpoint directory of this command to begin with: its size, its words, its weights."""
    side: Annotated[int, msgspec.Meta(ge=64, le=1024)] | None = None
    """Pictures are squashed to squares of so many pixels; default 352, or that of --from. More
    finds smaller things and takes more time, in training and afterwards."""
    words_only: bool = False
    """With --from: what sees pictures stays as it is, and only what is said of them is learned, in
    half of the time a step. For new names and phrases of what it tells apart already."""
    resume: bool = False
    """Go on from OUT/state.pt."""
    name: str = NAME
    """Of the model, in its card and its replies."""
    precision: Literal["auto", "float32", "bfloat16"] = "auto"
    """Of products; auto = bfloat16 where the processor has it."""


def train(arguments: list[str] | None = None) -> int:
    """Run the verb. Exit status: 0 done, 1 stopped or failed, 2 usage."""
    argv = sys.argv[1:] if arguments is None else arguments
    config = parse(TrainConfig, argv, program=PROGRAM)
    with needs_extra("train"):
        from w2c.clock import RealClock
        from w2c_grounding.train.interruption import continuation, interruptible
        from w2c_grounding.train.run import Run, Task
    task = Task(
        data=Path(config.data),
        out=Path(config.out),
        minutes=config.minutes,
        steps=config.steps,
        seed=config.seed,
        threads=config.threads,
        rate=config.rate,
        begin_with=Path(config.begin_with) if config.begin_with else None,
        side=config.side,
        words_only=config.words_only,
        resume=config.resume,
        name=config.name,
        precision=config.precision,
    )
    try:
        with interruptible() as stopped:
            scores = Run(task, RealClock(), lambda line: print(line, flush=True))(stopped)
    except W2CError as error:
        return fail(error, PROGRAM)
    if scores is None:
        print(continuation(PROGRAM, argv))
        return STOPPED
    print(msgspec.json.format(msgspec.json.encode(scores), indent=1).decode())
    return 0
