"""The prompt sets, by the name that the configuration gives."""

from collections.abc import Callable
from typing import Literal

from w2c_dialogue.prompts.base import PromptSet
from w2c_dialogue.prompts.embedded import EmbeddedPrompts
from w2c_dialogue.prompts.large import LargePrompts

PromptSetName = Literal["embedded", "large"]

PROMPT_SETS: dict[PromptSetName, Callable[[], PromptSet]] = {
    "embedded": EmbeddedPrompts,
    "large": LargePrompts,
}
