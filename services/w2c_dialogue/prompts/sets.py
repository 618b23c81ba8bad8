"""The prompt sets, by the name that the configuration gives."""

from collections.abc import Callable
from typing import Literal

from w2c_dialogue.prompts.base import PromptSet
from w2c_dialogue.prompts.embedded import EmbeddedPrompts
from w2c_dialogue.prompts.large import LargePrompts

PromptSetName = Literal["embedded", "large"]

AnswerForm = Literal["as_set", "bound", "free"]

PROMPT_SETS: dict[PromptSetName, Callable[[], PromptSet]] = {
    "embedded": EmbeddedPrompts,
    "large": LargePrompts,
}


def make_prompts(name: PromptSetName, answers: AnswerForm = "as_set") -> PromptSet:
    """Return a prompt set whose answers are bound to what is there, free, or as it is made for."""
    if answers == "as_set":
        return PROMPT_SETS[name]()
    bound = answers == "bound"
    return EmbeddedPrompts(bound=bound) if name == "embedded" else LargePrompts(bound=bound)
