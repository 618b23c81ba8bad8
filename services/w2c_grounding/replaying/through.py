"""`w2c replay FILE --through grounding`: the same pictures and phrases once more, by score.

Of each phrase are compared: whether it was found, its score, the heatmap (as a share of certain),
the point (as a share of the picture's diagonal), and of each box what it does not share with the
recorded one, 1 - IoU. Kernels of other machines round otherwise: nothing is expected bit by bit.
"""

import math
import time
from collections.abc import Iterator

import numpy as np

from w2c.difference import INFINITE, Difference
from w2c.errors import ConfigError, W2CError
from w2c.messages import Box, GroundingReply, GroundingRequest, PhraseEvidence
from w2c.through import Asked, Compared, Session, Skipped, configuration
from w2c_grounding.answer import Grounder
from w2c_grounding.config import Config
from w2c_grounding.loaded import Remote, load_model
from w2c_grounding.registry import load

TOLERANCE = 0.02
"""Of every share and score"""
STREAM = "grounding/ground"


def through(session: Session, tolerance: float | None) -> Iterator[Compared | Skipped]:
    """Ask for the recorded phrases again. See `w2c.through.Through`."""
    config = configuration(session, "grounding", Config)
    model = load_model(load, config.model_config(), config.point_rule, time.monotonic_ns)
    try:
        if isinstance(model.model, Remote):
            raise ConfigError(
                f"the recorded answers are of {model.card.name}, which asks a model elsewhere: it "
                "is not asked again, which may cost money"
            )
        for asked in session.asked("grounding"):
            if isinstance(asked.request, GroundingRequest):
                yield compare(model.grounder, asked, TOLERANCE if tolerance is None else tolerance)
    finally:
        model.close()


def compare(grounder: Grounder, asked: Asked, tolerance: float) -> Compared | Skipped:
    """Answer a recorded request, and compare."""
    request, reply = asked.request, asked.reply
    if not isinstance(request, GroundingRequest) or not isinstance(reply, GroundingReply):
        return Skipped(STREAM, asked.seconds, f"it was not answered then: {asked.outcome}")
    try:
        found = list(reply_differences(reply, grounder.ground(request)))
    except W2CError as error:
        found = [Difference("", "an answer", str(error), INFINITE)]
    phrases = ", ".join(f"'{phrase}'" for phrase in request.phrases[:4])
    what = f"{phrases}{' ...' if len(request.phrases) > 4 else ''}"
    inputs = (
        f"a picture of {len(request.jpeg)} bytes, {reply.width} x {reply.height} px; "
        f"{request.want} of {', '.join(request.phrases)}",
        *(f"picture: {one.key} number {one.sequence}" for one in asked.inputs),
    )
    return Compared(STREAM, what, asked.seconds, found, tolerance, inputs)


def reply_differences(recorded: GroundingReply, made: GroundingReply) -> Iterator[Difference]:
    """Yield in what two replies differ, each as a number between 0 and 1, or infinity."""
    if recorded.model != made.model:
        yield Difference("model", recorded.model, made.model, INFINITE)
    diagonal = math.hypot(recorded.width, recorded.height)
    for one, other in zip(recorded.evidence, made.evidence, strict=True):
        yield from _evidence_differences(one, other, diagonal)


def _evidence_differences(
    recorded: PhraseEvidence, made: PhraseEvidence, diagonal: float
) -> Iterator[Difference]:
    name = recorded.phrase
    if recorded.found != made.found:
        yield Difference(f"{name}.found", recorded.found, made.found, INFINITE)
    yield from _number(f"{name}.score", recorded.score, made.score)
    if recorded.unknown_words != made.unknown_words:
        words = recorded.unknown_words, made.unknown_words
        yield Difference(f"{name}.unknown_words", *words, INFINITE)
    if recorded.point is not None and made.point is not None:
        share = math.dist(recorded.point, made.point) / diagonal
        if share > 0.0:
            yield Difference(f"{name}.point", recorded.point, made.point, share)
    elif recorded.point != made.point:
        yield Difference(f"{name}.point", recorded.point, made.point, INFINITE)
    if len(recorded.boxes) != len(made.boxes):
        counts = len(recorded.boxes), len(made.boxes)
        yield Difference(f"{name}.boxes (length)", *counts, INFINITE)
    for index, (one, other) in enumerate(zip(recorded.boxes, made.boxes, strict=False)):
        missed = 1.0 - overlap(one, other)
        if missed > 0.0:
            yield Difference(f"{name}.boxes[{index}]", one, other, missed)
        yield from _number(f"{name}.boxes[{index}].score", one.score, other.score)
    yield from _heat(name, recorded, made)


def _heat(name: str, recorded: PhraseEvidence, made: PhraseEvidence) -> Iterator[Difference]:
    first, second = recorded.heatmap, made.heatmap
    if first is None or second is None or first.shape != second.shape:
        if first is not second:
            shapes = [None if one is None else one.shape for one in (first, second)]
            yield Difference(f"{name}.heatmap (shape)", shapes[0], shapes[1], INFINITE)
        return
    most = float(np.abs(first.astype(np.float64) - second.astype(np.float64)).max(initial=0.0))
    if most > 0.0:
        yield Difference(f"{name}.heatmap", "one", "another", most / 255.0)


def _number(path: str, recorded: float, made: float) -> Iterator[Difference]:
    if recorded != made:
        yield Difference(path, recorded, made, abs(recorded - made))


def overlap(one: Box, other: Box) -> float:
    """Return the intersection over the union of two boxes."""
    across = min(one.right, other.right) - max(one.left, other.left)
    along = min(one.bottom, other.bottom) - max(one.top, other.top)
    shared = max(across, 0.0) * max(along, 0.0)
    areas = [(box.right - box.left) * (box.bottom - box.top) for box in (one, other)]
    union = sum(areas) - shared
    return shared / union if union > 0.0 else 1.0
