"""Module selector: is this a new instruction, a correction, or a yes?

Paper, Methods, "Module Selector".
"""

from dataclasses import dataclass

from w2c.errors import ModelError
from w2c_dialogue.interfaces import LanguageModel
from w2c_dialogue.prompts.base import MODULES, PromptSet
from w2c_dialogue.utterance import Utterance

IMPOSSIBLE = -30.0
"""Log prior of what cannot be meant: far below what any likelihood makes up for."""
SURE = 0.8
"""A yes sets the robot in motion; below this probability the operator is asked."""


@dataclass(frozen=True)
class Selection:
    """Which module an utterance is for, with the probability of each."""

    module: str
    probabilities: dict[str, float]

    @property
    def sure(self) -> bool:
        """Say whether the choice may be acted upon without asking."""
        return self.probabilities.get(self.module, 0.0) >= SURE

    @property
    def margin(self) -> float:
        """How much more probable it is than the next one, 0 to 1."""
        return self.probabilities.get(self.module, 0.0) - self._second()[0]

    @property
    def next_best(self) -> str:
        """The module that is the second most probable; "" = there is none."""
        return self._second()[1]

    def _second(self) -> tuple[float, str]:
        others = [(p, name) for name, p in self.probabilities.items() if name != self.module]
        return max(others, default=(0.0, ""))


def log_prior(*, has_target: bool) -> dict[str, float]:
    """Return the paper's bias: without a target there is nothing to correct or to confirm."""
    return {} if has_target else {"correction": IMPOSSIBLE, "confirmation": IMPOSSIBLE}


def select(
    model: LanguageModel, prompts: PromptSet, utterance: Utterance, *, has_target: bool
) -> Selection:
    """Choose the module.

    Raises:
        ModelError: the answer is none of the options.
        CallError: the model does not answer.
    """
    choice = model.choose(prompts.select(utterance), log_prior(has_target=has_target))
    if choice.option not in MODULES:
        raise ModelError(f"'{choice.option[:40]}' is none of {', '.join(MODULES)}")
    if not has_target and choice.option != "prediction":
        # A backend may not honour priors; the state of the conversation is known here for certain.
        return Selection("prediction", {"prediction": 1.0})
    return Selection(choice.option, choice.probabilities)
