"""Flags of the dialogue service."""

from typing import Annotated

import msgspec

from w2c.config import ServiceConfig
from w2c_dialogue.advice.veto import UncheckedVeto
from w2c_dialogue.advice.wordlist import FRAGILE, VETOED
from w2c_dialogue.prompts.sets import AnswerForm, PromptSetName


class DialogueConfig(ServiceConfig, frozen=True, kw_only=True):
    """The conversation with the operator: words, clicks and confirmations to targets and goals."""

    prompts: PromptSetName = "embedded"
    """Prompt set: `embedded` for the model of this repository, `large` for any general model."""
    answers: AnswerForm = "as_set"
    """Form of the model's answers: `bound` = objects are words of the utterance, expressions hold
    its numbers and symbols of the scene only; `free` = any phrase and any arithmetic; `as_set` =
    bound for `embedded`, free for `large`."""
    seed: int = 0
    """Seed of the language model's answers."""
    ask_margin: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.2
    """An utterance whose module is less than this more probable than the next one is asked about.
    Of 130 held-out sentences 4 are: guessed, 3 of them would be right; beyond, 116 of 126. 0 =
    never ask."""
    model_timeout: Annotated[float, msgspec.Meta(gt=0, le=600)] = 30.0
    """Deadline of one question to the language model, or of one look at a picture [s]."""
    veto: tuple[str, ...] = VETOED
    """What is never touched: a target where the picture shows one of these phrases cannot be
    confirmed. A vision model checks only phrases whose words it knows; the health says which it
    does not. Empty = no veto."""
    veto_share: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.3
    """A veto phrase is at a place from this share of its highest heat in the picture on. Less =
    more careful."""
    veto_margin: Annotated[float, msgspec.Meta(ge=0, le=0.5)] = 0.05
    """How far around the target is looked for what is never touched [m]: a hand's radius."""
    unchecked_veto: UncheckedVeto = "refuse"
    """What follows where grounding does not answer: `refuse` = nothing is confirmed, `allow` = the
    operator is told."""
    fragile: tuple[str, ...] = tuple(FRAGILE)
    """What may not bear a hand: the operator is told where the picture shows it."""
    advice_timeout: Annotated[float, msgspec.Meta(gt=0, le=60)] = 5.0
    """Deadline of each question that advice or the veto asks [s]."""
    masked_pointing: bool = False
    """Point only where a hand may go and gets to: heatmaps are masked by flat, large enough, not
    too steep and not vetoed, and a few points are tried for reach. Off: advice comes afterwards."""
    pointing_budget: Annotated[float, msgspec.Meta(gt=0, le=10)] = 0.5
    """With masked pointing: no second, third ... point is tried for reach after so long [s]."""
    goal_silence: Annotated[float, msgspec.Meta(gt=0)] = 5.0
    """A goal the controller's status has not named for so long is given up [s]."""
