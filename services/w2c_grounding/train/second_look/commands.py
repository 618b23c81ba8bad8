"""`w2c train second-look`: teach a checkpoint to look at regions from near."""

from typing import TYPE_CHECKING

from w2c_grounding.train.addition.commands import AdditionConfig, run_command

if TYPE_CHECKING:
    from w2c_grounding.train.second_look.run import SecondLookAddition

PROGRAM = "w2c train second-look"


class SecondLookConfig(AdditionConfig, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Train the second look of a vision model on pictures of `w2c scenes render`.

    Writes OUT/checkpoint (that of --checkpoint with the second look and a new threshold),
    OUT/scores.json and, every five minutes, OUT/state.pt for --resume. One picture in twenty of
    --data is not trained on: the threshold is calibrated there. The things of 10,000 pictures take
    1.6 GB of memory. Ctrl-C or SIGTERM ends a training at its next step.
    """


def train(arguments: list[str] | None = None) -> int:
    """Run the verb. Exit status: 0 done, 1 stopped or failed, 2 usage."""
    return run_command(PROGRAM, SecondLookConfig, _addition, arguments)


def _addition() -> "type[SecondLookAddition]":
    from w2c_grounding.train.second_look.run import SecondLookAddition

    return SecondLookAddition
