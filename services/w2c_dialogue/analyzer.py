"""Prompt analyzer: which objects, and is the place on them or relative to them?

Paper, Methods, "Prompt Analyzer".
"""

from collections.abc import Sequence
from dataclasses import dataclass

from w2c.errors import ModelError
from w2c_dialogue.answers import AnalysisAnswer, ObjectsAnswer, read
from w2c_dialogue.interfaces import LanguageModel
from w2c_dialogue.prompts.base import PromptSet
from w2c_dialogue.utterance import Mention, Utterance

MAX_PHRASE = 100
"""Characters; the grounding service takes no more."""


@dataclass(frozen=True)
class Analysis:
    """What an instruction says about the place."""

    position: str
    """absolute or relative"""
    mentions: tuple[Mention, ...]
    """Objects in order of mention"""


def analyze(model: LanguageModel, prompts: PromptSet, utterance: Utterance) -> Analysis:
    """Return kind of position and objects of an instruction. Raises ModelError, CallError."""
    answer = read(model.complete(prompts.analyze(utterance)), AnalysisAnswer)
    return Analysis(answer.position, _mentions(prompts, utterance, answer.objects))


def objects_of_correction(
    model: LanguageModel, prompts: PromptSet, utterance: Utterance
) -> tuple[Mention, ...]:
    """Return the objects a correction speaks of, often none. Raises ModelError, CallError."""
    answer = read(model.complete(prompts.objects(utterance)), ObjectsAnswer)
    return _mentions(prompts, utterance, answer.objects)


def _mentions(
    prompts: PromptSet, utterance: Utterance, entries: Sequence[str]
) -> tuple[Mention, ...]:
    """Read the entries; one that repeats or overlaps an earlier one adds nothing."""
    mentions: list[Mention] = []
    for entry in entries:
        mention = prompts.read_mention(entry, utterance)
        if len(mention.phrase) > MAX_PHRASE:
            raise ModelError(f"'{mention.phrase[:40]}...' is too long for the name of an object")
        if mention.phrase and not any(_overlap(mention, known) for known in mentions):
            mentions.append(mention)
    return tuple(mentions)


def _overlap(one: Mention, other: Mention) -> bool:
    if one.span is None or other.span is None:
        return one.phrase.lower() == other.phrase.lower()
    return one.span[0] <= other.span[1] and other.span[0] <= one.span[1]
