"""`w2c train outline`: teach a checkpoint where things end."""

from typing import TYPE_CHECKING

from w2c_grounding.train.addition.commands import AdditionConfig, run_command

if TYPE_CHECKING:
    from w2c_grounding.train.outline.run import OutlineAddition

PROGRAM = "w2c train outline"


class OutlineConfig(AdditionConfig, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Train the outlines of a vision model on pictures of `w2c scenes render`.

    Asks --checkpoint about up to 4,000 of the pictures, and learns where the things end that it
    lights there. Writes OUT/checkpoint (that of --checkpoint with outlines), OUT/scores.json (how
    well boxes fit, on pictures that were not trained on) and, every five minutes, OUT/state.pt for
    --resume. What 4,000 pictures light takes 1.7 GB of memory, and twice that for a moment. Ctrl-C
    or SIGTERM ends a training at its next step.
    """


def train(arguments: list[str] | None = None) -> int:
    """Run the verb. Exit status: 0 done, 1 stopped or failed, 2 usage."""
    return run_command(PROGRAM, OutlineConfig, _addition, arguments)


def _addition() -> "type[OutlineAddition]":
    from w2c_grounding.train.outline.run import OutlineAddition

    return OutlineAddition
