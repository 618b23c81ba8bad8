"""Prompt sets without one of the paper's ingredients, to see what it is worth.

Paper, Methods, "Prompting LLMs" (five examples), "Prompt Analyzer" (chain of thought) and
"Relative Positions" (arithmetic that is left to a parser: "around 10 %"). What is taken away is
taken out of the questions of an existing set: nothing else changes.
"""

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal

import msgspec

from w2c.errors import ConfigError
from w2c.messages import ChatMessage
from w2c_dialogue.expressions import evaluate
from w2c_dialogue.prompts.base import (
    CorrectionScene,
    PromptSet,
    Question,
    SceneObject,
    schema_of,
)
from w2c_dialogue.prompts.single import SinglePrompt
from w2c_dialogue.utterance import Mention, Utterance

AblationName = Literal["none", "direct_number", "no_reasoning", "zero_shot", "single_prompt"]
Change = Callable[[Question], Question]

THOUGHT = "chain_of_thought"
_THINKING = re.compile(r"Think first[^.]*\.\s*")
_ARITHMETIC = re.compile(r"x and y as arithmetic.*?parentheses[^.]*\.", re.DOTALL)
_NUMBER = {"type": "string", "pattern": "^-?[0-9]{1,5}([.][0-9]{1,2})?$"}


def ablated(prompts: PromptSet, name: AblationName) -> PromptSet:
    """Return a prompt set without an ingredient.

    direct_number: the model computes the point itself. no_reasoning: no chain of thought.
    zero_shot: no examples. single_prompt: one question for everything (its answers need
    `single.AskedOnce` around the model).

    Raises:
        ConfigError: the set never had it.
    """
    if name == "none":
        return prompts
    if prompts.name != "large":
        raise ConfigError(
            f"--ablation {name}: the prompt set '{prompts.name}' has no examples, no chain of "
            "thought and no numbers to take away, and cannot answer everything at once; ablations "
            "are for general models (--prompts large)"
        )
    if name == "single_prompt":
        return SinglePrompt(prompts)
    changes: dict[str, Change] = {
        "direct_number": direct_number,
        "no_reasoning": no_reasoning,
        "zero_shot": zero_shot,
    }
    return _Ablated(prompts, name, changes[name])


def no_reasoning(question: Question) -> Question:
    """Return a question that is answered without a chain of thought."""
    messages = _rewritten(question, _without_thought, lambda text: _THINKING.sub("", text))
    return replace(question, messages=messages, schema=_schema_without(question.schema, THOUGHT))


def zero_shot(question: Question) -> Question:
    """Return a question without examples."""
    kept = tuple(m for m in question.messages[: question.constant_messages] if m.role == "system")
    asked = question.messages[question.constant_messages :]
    return replace(question, messages=(*kept, *asked), constant_messages=len(kept))


def direct_number(question: Question) -> Question:
    """Return a question whose answer is the point itself, not the way to it."""
    if question.task not in ("relative", "correct") or question.schema is None:
        return question
    properties = dict(question.schema["properties"])
    properties |= {"x": _NUMBER, "y": _NUMBER}
    messages = _rewritten(
        question, _computed, lambda text: _ARITHMETIC.sub("x and y as numbers.", text)
    )
    return replace(question, messages=messages, schema=schema_of(properties))


class _Ablated:
    """A prompt set whose questions are changed."""

    def __init__(self, prompts: PromptSet, name: str, change: Change) -> None:
        self._prompts = prompts
        self._change = change
        self.name = f"{prompts.name}, {name}"

    def select(self, utterance: Utterance) -> Question:
        """Ask which module an utterance is for."""
        return self._change(self._prompts.select(utterance))

    def analyze(self, utterance: Utterance) -> Question:
        """Ask for `position` and `objects` of an instruction."""
        return self._change(self._prompts.analyze(utterance))

    def objects(self, utterance: Utterance) -> Question:
        """Ask for the `objects` of a correction."""
        return self._change(self._prompts.objects(utterance))

    def read_mention(self, value: str, utterance: Utterance) -> Mention:
        """Return what an entry of `objects` names. Raises ModelError."""
        return self._prompts.read_mention(value, utterance)

    def relative(
        self,
        utterance: Utterance,
        mentions: Sequence[Mention],
        objects: Sequence[SceneObject],
        pixels_per_cm: float,
    ) -> Question:
        """Ask for a point relative to objects."""
        return self._change(self._prompts.relative(utterance, mentions, objects, pixels_per_cm))

    def correct(
        self, utterance: Utterance, mentions: Sequence[Mention], scene: CorrectionScene
    ) -> Question:
        """Ask for the corrected target."""
        return self._change(self._prompts.correct(utterance, mentions, scene))

    def parts(self, utterance: Utterance) -> tuple[Utterance, ...]:
        """Return what the set without the ablation returns."""
        return self._prompts.parts(utterance)

    def effector(self, utterance: Utterance) -> Question:
        """Ask for `effector` and `task`."""
        return self._change(self._prompts.effector(utterance))


def _rewritten(
    question: Question,
    answer: Callable[[dict[str, Any]], dict[str, Any]],
    system: Callable[[str], str],
) -> tuple[ChatMessage, ...]:
    """Return the messages with other examples' answers and another system prompt."""
    result = []
    for number, message in enumerate(question.messages):
        content = message.content
        if message.role == "system":
            content = system(content)
        elif message.role == "assistant" and number < question.constant_messages:
            content = _answer(content, answer)
        result.append(msgspec.structs.replace(message, content=content))
    return tuple(result)


def _answer(text: str, change: Callable[[dict[str, Any]], dict[str, Any]]) -> str:
    """Return the answer of an example, changed; one that is no JSON object stays."""
    try:
        value = json.loads(text)
    except ValueError:
        return text
    return msgspec.json.encode(change(value)).decode() if isinstance(value, dict) else text


def _without_thought(value: dict[str, Any]) -> dict[str, Any]:
    return {key: entry for key, entry in value.items() if key != THOUGHT}


def _computed(value: dict[str, Any]) -> dict[str, Any]:
    """Return an answer with its arithmetic done."""
    numbers: dict[str, Any] = {
        axis: f"{evaluate(value[axis], {}):.0f}" for axis in ("x", "y") if axis in value
    }
    return {**value, **numbers}


def _schema_without(schema: dict[str, Any] | None, field: str) -> dict[str, Any] | None:
    if schema is None:
        return None
    return schema_of({k: v for k, v in schema["properties"].items() if k != field})
