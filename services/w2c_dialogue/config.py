"""Flags of the dialogue service."""

from typing import Annotated, Literal

import msgspec

from w2c.config import ServiceConfig


class DialogueConfig(ServiceConfig, frozen=True, kw_only=True):
    """The conversation with the operator: words, clicks and confirmations to targets and goals."""

    prompts: Literal["embedded", "large"] = "embedded"
    """Prompt set: `embedded` for the model of this repository, `large` for any general model."""
    seed: int = 0
    """Seed of the language model's answers."""
    model_timeout: Annotated[float, msgspec.Meta(gt=0, le=600)] = 30.0
    """Deadline of one question to the language model, or of one look at a picture [s]."""
    goal_silence: Annotated[float, msgspec.Meta(gt=0)] = 5.0
    """A goal the controller's status has not named for so long is given up [s]."""
