"""What the commands that add a network to a checkpoint have in common: their flags, their end."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec

from w2c.config import fail, parse
from w2c.errors import W2CError
from w2c.extras import needs_extra

if TYPE_CHECKING:
    from collections.abc import Callable

    from w2c_grounding.train.addition.run import Addition, Material

STOPPED = 1


class AdditionConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Flags."""

    data: str
    """Directory of pictures to train on."""
    out: str
    """Directory for the results."""
    checkpoint: str
    """A checkpoint directory of `w2c train grounding`; if it has such a network, that is gone on
    from."""
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


def run_command(
    program: str,
    flags: type[AdditionConfig],
    addition: "Callable[[], Callable[[Material], Addition]]",
    arguments: list[str] | None,
) -> int:
    """Run a verb. Exit status: 0 done, 1 stopped or failed, 2 usage.

    Args:
        program: As it is called.
        flags: Its own, with its help.
        addition: Imports what trains: that takes seconds, which --help should not.
        arguments: None = those of the process.
    """
    argv = sys.argv[1:] if arguments is None else arguments
    config = parse(flags, argv, program=program)
    with needs_extra("train"):
        from w2c.clock import RealClock
        from w2c_grounding.train.addition.run import Task, add
        from w2c_grounding.train.interruption import continuation, interruptible

        prepare = addition()
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
            scores = add(prepare, task, RealClock(), lambda line: print(line, flush=True), stopped)
    except W2CError as error:
        return fail(error, program)
    if scores is None:
        print(continuation(program, argv))
        return STOPPED
    print(msgspec.json.format(msgspec.json.encode(scores), indent=1).decode())
    return 0
