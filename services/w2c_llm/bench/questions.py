"""Five kinds of question with long constant prefixes, as few-shot prompts of large models have."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from w2c.messages import ChatMessage, CompleteRequest

_MAX_TOKENS = 80


@dataclass(frozen=True)
class Kind:
    """One kind of question."""

    name: str
    task: str
    """System prompt"""
    schema: dict[str, Any]
    examples: tuple[str, ...]
    """Answers of the examples, in turn"""
    numbered: bool = False
    """The words carry their numbers, so that an answer can point at them"""


def _closed(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "properties": properties, "required": list(properties)}


def _pattern(text: str) -> dict[str, Any]:
    return {"type": "string", "pattern": f"^{text}$"}


_SPAN = _pattern("[1-9]-[1-9]")
_BESIDE = r"a\.(left|right|top|bottom|u|v)([-+](0\.5\*)?a\.(width|height))?"
_MOVED = r"(target\.[uv]|a\.[uv])([-+](20|40|100|2\*last\.d[uv]))?"

KINDS = (
    Kind(
        "select",
        "Say what an utterance to the robot is: a new instruction, a correction of the target that "
        "is shown, or its confirmation.",
        {"enum": ["prediction", "correction", "confirmation"]},
        ('"prediction"', '"correction"', '"confirmation"'),
    ),
    Kind(
        "analyze",
        "Find the things that an instruction names, by the numbers of their words, and whether "
        "the place is on them or relative to them.",
        _closed(
            position={"enum": ["absolute", "relative"]},
            objects={"type": "array", "items": _SPAN, "minItems": 1, "maxItems": 2},
        ),
        (
            '{"position":"absolute","objects":["4-5"]}',
            '{"position":"relative","objects":["2-3","6-6"]}',
        ),
        numbered=True,
    ),
    Kind(
        "relative",
        "Where is the place that is described relative to the thing a? Answer with arithmetic of "
        "its sides, left of it is smaller x.",
        _closed(x=_pattern(_BESIDE), y=_pattern(_BESIDE)),
        ('{"x":"a.right+0.5*a.width","y":"a.v"}', '{"x":"a.u","y":"a.top-0.5*a.height"}'),
    ),
    Kind(
        "correct",
        "The operator corrects the target. Where does it go? Answer with arithmetic of the target, "
        "the thing a and the last move.",
        _closed(x=_pattern(_MOVED), y=_pattern(_MOVED)),
        ('{"x":"target.u-20","y":"target.v"}', '{"x":"target.u+2*last.du","y":"a.v"}'),
    ),
    Kind(
        "effector",
        "Which hand or foot does an instruction name, and does it lean there or only reach?",
        _closed(
            effector={
                "enum": ["left_hand", "right_hand", "left_foot", "right_foot", "unspecified"]
            },
            task={"enum": ["contact", "reach"]},
        ),
        (
            '{"effector":"left_hand","task":"contact"}',
            '{"effector":"unspecified","task":"reach"}',
        ),
    ),
)

_VERBS = (
    "lean on",
    "put your left hand on",
    "reach",
    "rest your right palm on",
    "move it closer to",
)
_PLACES = ("", "to the left of", "behind", "a bit above", "right next to")
_COLOURS = ("red", "wooden", "small", "white", "old")
_THINGS = ("table", "mug", "crate", "shelf", "kettle", "window sill", "book", "chair")


def utterances(rng: np.random.Generator) -> Iterator[str]:
    """Yield sentences of about ten words, without end."""
    while True:
        parts = [str(rng.choice(words)) for words in (_VERBS, _PLACES, _COLOURS, _THINGS)]
        ending = f"and mind the {rng.choice(_COLOURS)} {rng.choice(_THINGS)}"
        yield " ".join(part for part in (*parts[:2], "the", *parts[2:], ending) if part)


def prefix_of(
    kind: Kind,
    tokens: int,
    count_tokens: Callable[[list[ChatMessage]], int],
    rng: np.random.Generator,
) -> list[ChatMessage]:
    """Return the constant messages of a kind: its task, and examples until there are `tokens`."""
    messages = [ChatMessage(role="system", content=kind.task)]
    for index, words in enumerate(utterances(rng)):
        if count_tokens(messages) >= tokens:
            break
        answer = kind.examples[index % len(kind.examples)]
        messages += [
            _asked(kind, words),
            ChatMessage(role="assistant", content=answer),
        ]
    return messages


def question(kind: Kind, prefix: list[ChatMessage], words: str) -> CompleteRequest:
    """Return the question about an utterance."""
    return CompleteRequest(
        messages=[*prefix, _asked(kind, words)],
        schema=kind.schema,
        max_tokens=_MAX_TOKENS,
        constant_messages=len(prefix),
    )


def _asked(kind: Kind, words: str) -> ChatMessage:
    if kind.numbered:
        words = " ".join(f"{word}{number}" for number, word in enumerate(words.split(), 1))
    return ChatMessage(role="user", content=words)
