"""Lines of the corpus: a question exactly as it is asked at run time, and the right answer."""

from collections.abc import Iterator, Sequence
from typing import Any

import msgspec
import numpy as np

from w2c.messages import Box
from w2c_dialogue.corpus import corrections, instructions
from w2c_dialogue.corpus.confirmations import confirmation
from w2c_dialogue.corpus.draft import Draft
from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.noise import disturb
from w2c_dialogue.corpus.steering import Correction
from w2c_dialogue.corpus.written import (
    written_correction,
    written_instruction,
    written_words,
)
from w2c_dialogue.corpus.written_lines import KIND_OF_MODULE
from w2c_dialogue.prompts.base import MODULES, CorrectionScene, Move, Question, SceneObject
from w2c_dialogue.prompts.embedded import EmbeddedPrompts
from w2c_dialogue.prompts.spans import naming_spans
from w2c_dialogue.utterance import Mention, Utterance

PROMPTS = EmbeddedPrompts(bound=False)
"""The same questions; the schemas of bound answers would take most of the time."""
SHARES = (
    (0.18, "select"),
    (0.28, "analyze"),
    (0.07, "objects"),
    (0.14, "relative"),
    (0.25, "correct"),
)
"""How often each task; the rest are effectors. Pointing and binding amounts are hardest."""
PLAIN_SHARE = 0.45
"""How many instructions are in few words and without slips."""
WRITTEN_SHARE = 0.5
"""How many sentences follow one that was written by hand; the others are drawn from grammar."""
WRITTEN_CHOICES = 0.7
"""The same, where a module is chosen: what a yes is like, no grammar tells"""
WIDTH, HEIGHT = 1280.0, 720.0


class Example(msgspec.Struct, frozen=True):
    """One line: what the model is asked, and what it shall answer, byte for byte."""

    task: str
    messages: list[dict[str, str]]
    answer: str


def examples(generator: np.random.Generator, count: int, *, held_out: bool) -> Iterator[Example]:
    """Yield lines. Held-out lines use entries of the word lists that training lines never use."""
    draw = Draw(generator, held_out=held_out)
    for _ in range(count):
        yield _MAKERS[draw.by_share(SHARES, "effector")](draw)


def answer_text(value: dict[str, Any]) -> str:
    """Return the JSON a model shall write: no spaces, properties in the order of the schema."""
    return msgspec.json.encode(value).decode()


def example(question: Question, answer: str) -> Example:
    """Return the line of a question and the text that answers it."""
    messages = [{"role": m.role, "content": m.content} for m in question.messages]
    return Example(task=question.task, messages=messages, answer=answer)


def _cut(draft: Draft, draw: Draw, *, plain: bool = False) -> tuple[Utterance, list[Mention]]:
    utterance, spans = (draft if plain else disturb(draft, draw)).finish()
    return utterance, [Mention(utterance.phrase(span), span) for span in spans]


def _instruction(
    draw: Draw, relative: float = 0.5
) -> tuple[instructions.Instruction, Utterance, list[Mention]]:
    kind = "relative" if draw.chance(relative) else "absolute"
    while True:
        if draw.chance(WRITTEN_SHARE):
            made, plain = written_instruction(draw, kind), False
        else:
            plain = draw.chance(PLAIN_SHARE)
            made = instructions.instruction(draw, kind, plain=plain)
        utterance, mentions = _cut(made.draft, draw, plain=plain)
        if _may_be_named(utterance, mentions):
            return made, utterance, mentions


def _may_be_named(utterance: Utterance, mentions: Sequence[Mention]) -> bool:
    """Tell whether the names can be answered: without its comma one runs into what follows."""
    return {mention.span for mention in mentions} <= set(naming_spans(utterance))


def _select(draw: Draw) -> Example:
    module = draw.pick(MODULES)
    if draw.chance(WRITTEN_CHOICES):
        utterance, _ = _cut(written_words(draw, KIND_OF_MODULE[module]), draw)
    elif module == "prediction":
        vague = draw.chance(0.04)
        utterance = _cut(instructions.vague(draw), draw)[0] if vague else _instruction(draw)[1]
    elif module == "correction":
        utterance, _ = _cut(corrections.correction(draw).draft, draw)
    else:
        utterance, _ = _cut(confirmation(draw), draw)
    return example(PROMPTS.select(utterance), module)


def _analyze(draw: Draw) -> Example:
    if draw.chance(0.03):
        utterance, _ = _cut(instructions.vague(draw), draw)
        answer: dict[str, Any] = {"position": "absolute", "objects": []}
        return example(PROMPTS.analyze(utterance), answer_text(answer))
    made, utterance, mentions = _instruction(draw)
    answer = {"position": made.position, "objects": [str(m.span) for m in mentions]}
    return example(PROMPTS.analyze(utterance), answer_text(answer))


def _correction(draw: Draw) -> Correction:
    return written_correction(draw) if draw.chance(WRITTEN_SHARE) else corrections.correction(draw)


def _objects(draw: Draw) -> Example:
    utterance, mentions = _cut(_correction(draw).draft, draw)
    while not _may_be_named(utterance, mentions):
        utterance, mentions = _cut(_correction(draw).draft, draw)
    answer = {"objects": [str(m.span) for m in mentions]}
    return example(PROMPTS.objects(utterance), answer_text(answer))


def _relative(draw: Draw) -> Example:
    made, utterance, mentions = _instruction(draw, 1.0)
    objects = _scene_objects(draw, made.scene, len(mentions))
    question = PROMPTS.relative(utterance, mentions, objects, 10.0)
    return example(question, answer_text({"x": made.x, "y": made.y}))


def _correct(draw: Draw) -> Example:
    made = _correction(draw)
    utterance, mentions = _cut(made.draft, draw)
    while not mentions and len(PROMPTS.parts(utterance)) > 1:
        # The model is never asked this: it is asked for each part.
        made = _correction(draw)
        utterance, mentions = _cut(made.draft, draw)
    moves = tuple(_move(draw) for _ in range(made.needs_past + draw.below(4)))
    objects = tuple(_scene_objects(draw, made.scene, len(mentions)))
    scene = CorrectionScene((640.0, 360.0), (640.0, 360.0), moves, (), objects, 10.0)
    return example(
        PROMPTS.correct(utterance, mentions, scene), answer_text({"x": made.x, "y": made.y})
    )


def _effector(draw: Draw) -> Example:
    made, utterance, _ = _instruction(draw)
    answer = {"effector": made.effector, "task": made.task}
    return example(PROMPTS.effector(utterance), answer_text(answer))


def _move(draw: Draw) -> Move:
    """Return a past correction; most are along an axis."""
    du, dv = draw.between(-100, 100), draw.between(-100, 100)
    kind = draw.below(3)
    return Move(du if kind != 1 else 0.0, dv if kind != 0 else 0.0)


def _box(draw: Draw, u: float, v: float) -> Box:
    width, height = draw.between(30, 150), draw.between(30, 150)
    return Box(
        left=u - width / 2,
        top=v - height / 2,
        right=u + width / 2,
        bottom=v + height / 2,
        score=0.9,
    )


def _scene_objects(draw: Draw, scene: str, count: int) -> list[SceneObject]:
    """Return boxes of which the facts in `scene` are true."""
    u, v = draw.between(100, WIDTH - 100), draw.between(100, HEIGHT - 100)
    if scene in ("A left", "A middle", "A right"):
        third = ("A left", "A middle", "A right").index(scene)
        u = WIDTH * (third + draw.between(0.02, 0.98)) / 3.0
    centres = [(u, v)]
    relations = {"left": (1, 0), "right": (-1, 0), "above": (0, 1), "below": (0, -1)}
    word = scene.split()[1] if scene.endswith("B") else draw.pick(tuple(relations))
    du, dv = relations[word]
    far, aside = draw.between(200, 400), draw.between(-30, 30)
    centres.append((u + du * far + dv * aside, v + dv * far + du * aside))
    centres.append((draw.between(100, WIDTH - 100), draw.between(100, HEIGHT - 100)))
    return [SceneObject("", _box(draw, *centre)) for centre in centres[:count]]


_MAKERS = {
    "select": _select,
    "analyze": _analyze,
    "objects": _objects,
    "relative": _relative,
    "correct": _correct,
    "effector": _effector,
}
