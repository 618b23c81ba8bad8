"""`w2c train things`: teach a checkpoint where the things of a picture are."""

from typing import TYPE_CHECKING

from w2c_grounding.train.addition.commands import AdditionConfig, run_command

if TYPE_CHECKING:
    from w2c_grounding.train.things.run import ThingsAddition

PROGRAM = "w2c train things"


class ThingsConfig(AdditionConfig, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Train what finds the things of a picture before anything is asked.

    Learns from what the picture tower of --checkpoint sees in pictures of `w2c scenes render`, and
    from which pixels belong to which thing. For a checkpoint with a second look: that is then taken
    at each thing. Writes OUT/checkpoint (that of --checkpoint with the network and a new
    threshold), OUT/scores.json, OUT/pictures (may be removed afterwards) and, every five minutes,
    OUT/state.pt for --resume. One picture in twenty of --data is not trained on. Ctrl-C or SIGTERM
    ends a training at its next step.
    """


def train(arguments: list[str] | None = None) -> int:
    """Run the verb. Exit status: 0 done, 1 stopped or failed, 2 usage."""
    return run_command(PROGRAM, ThingsConfig, _addition, arguments)


def _addition() -> "type[ThingsAddition]":
    from w2c_grounding.train.things.run import ThingsAddition

    return ThingsAddition
