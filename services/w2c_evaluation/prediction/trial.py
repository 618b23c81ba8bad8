"""Ask every prompt of a dataset of every combination of models."""

from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from w2c.errors import MissingExtraError, W2CError
from w2c.library import library
from w2c_evaluation.benchmark.dataset import Item
from w2c_evaluation.benchmark.record import POSITIONS
from w2c_evaluation.prediction.combinations import Combination, ModelSpec
from w2c_evaluation.prediction.judging import Answer, accepts, first_error
from w2c_evaluation.prediction.services import Eye, Eyes, Language, Vision, service
from w2c_evaluation.prediction.true_vision import NAME, TrueVision

RANDOM_REPETITIONS = 101
"""Of points by chance: they cost nothing"""

Key = tuple[str, int, str]
"""Digest of the models, repetition, id of the record"""


@dataclass(frozen=True)
class Absent:
    """A combination that could not be asked."""

    combination: Combination
    reason: str


@dataclass(frozen=True)
class Options:
    """How prompts are asked."""

    repetitions: int
    seed: int
    temperature: float
    ablation: str


def run(
    items: Sequence[Item],
    combinations: Sequence[Combination],
    options: Options,
    done: Collection[Key],
) -> Iterator[Answer | Absent]:
    """Yield the answers that are not done, as they come.

    One language model is in memory at a time; vision models stay. A model that cannot be loaded
    leaves its combinations out, and says why.

    Raises:
        ConfigError: a prompt set has nothing that the ablation could take away.
        CallError: a service is gone.
    """
    with ExitStack() as kept:
        eyes: dict[str, Eye | W2CError] = {}
        for llm in dict.fromkeys(one.llm.digest for one in combinations):
            group = [one for one in combinations if one.llm.digest == llm]
            missing = [one for one in group if _missing(one, items, options, done)]
            if missing:
                yield from _of_language_model(missing, items, options, done, eyes, kept)


def _of_language_model(
    group: Sequence[Combination],
    items: Sequence[Item],
    options: Options,
    done: Collection[Key],
    eyes: dict[str, Eye | W2CError],
    kept: ExitStack,
) -> Iterator[Answer | Absent]:
    with ExitStack() as stack:
        try:
            bus = stack.enter_context(service("language_service", group[0].llm))
        except W2CError as error:
            _refuse_missing_extra(error)
            yield from (Absent(one, f"{one.llm.name}: {error}") for one in group)
            return
        language = Language(bus, temperature=options.temperature)
        for one in group:
            detector, segmenter = (
                _see(spec, items, eyes, kept) for spec in (one.detector, one.segmenter)
            )
            lost = next((e for e in (detector, segmenter) if isinstance(e, W2CError)), None)
            if isinstance(detector, W2CError) or isinstance(segmenter, W2CError):
                yield Absent(one, str(lost))
                continue
            predicting = library("predicting")(
                language,
                Eyes(detector, segmenter),
                prompts=one.llm.prompts,
                ablation=options.ablation,
            )
            for repetition, item in _missing(one, items, options, done):
                language.seed = options.seed + repetition
                for eye in (detector, segmenter):
                    if isinstance(eye, TrueVision):
                        eye.item = item
                yield ask(predicting, one, item, repetition)


def ask(predicting: Any, combination: Combination, item: Item, repetition: int) -> Answer:
    """Return what becomes of one prompt."""
    mask = item.accepted()
    height, width = mask.shape
    record = item.record
    predicted = predicting.predict(record.prompt, item.picture(), (width, height), record.px_per_cm)
    hit = accepts(mask, predicted.point)
    return Answer(
        models=combination.names,
        digest=combination.digest,
        repetition=repetition,
        id=record.id,
        hit=hit,
        error="" if hit else first_error(record, predicted),
        reason=predicted.reason,
        point=predicted.point,
        position=predicted.position,
        phrases=predicted.phrases,
        boxes=tuple((box.left, box.top, box.right, box.bottom) for box in predicted.boxes),
        asks=predicted.asks,
    )


def key_of(answer: Answer) -> Key:
    """Return what an answer answers."""
    return answer.digest, answer.repetition, answer.id


def count_missing(
    items: Sequence[Item],
    combinations: Sequence[Combination],
    options: Options,
    done: Collection[Key],
) -> int:
    """Return how many answers are not done."""
    return sum(len(_missing(one, items, options, done)) for one in combinations)


def random_rates(items: Sequence[Item], seed: int) -> dict[str, list[float]]:
    """Return how often points by chance hit, in each repetition, by position and overall."""
    rng = np.random.default_rng([seed, 51])
    hits = np.zeros((RANDOM_REPETITIONS, len(items)), bool)
    for number, item in enumerate(items):
        mask = item.accepted()
        rows = rng.integers(mask.shape[0], size=RANDOM_REPETITIONS)
        hits[:, number] = mask[rows, rng.integers(mask.shape[1], size=RANDOM_REPETITIONS)]
    positions = np.array([item.record.position for item in items])
    rates = {name: hits[:, positions == name] for name in POSITIONS} | {"overall": hits}
    return {name: part.mean(axis=1).tolist() for name, part in rates.items() if part.size}


def _missing(
    combination: Combination, items: Sequence[Item], options: Options, done: Collection[Key]
) -> list[tuple[int, Item]]:
    return [
        (repetition, item)
        for repetition in range(options.repetitions)
        for item in items
        if (combination.digest, repetition, item.record.id) not in done
    ]


def _see(
    spec: ModelSpec, items: Sequence[Item], eyes: dict[str, Eye | W2CError], kept: ExitStack
) -> Eye | W2CError:
    """Return a vision model, loaded once, or why it cannot be loaded."""
    if spec.digest not in eyes:
        try:
            if spec.name == NAME:
                eyes[spec.digest] = TrueVision(items)
            else:
                eyes[spec.digest] = Vision(kept.enter_context(service("grounding_service", spec)))
        except W2CError as error:
            _refuse_missing_extra(error)
            eyes[spec.digest] = type(error)(f"{spec.name}: {error}")
    return eyes[spec.digest]


def _refuse_missing_extra(error: W2CError) -> None:
    """Raise an error that no model here can be without."""
    if isinstance(error, MissingExtraError):
        raise error
