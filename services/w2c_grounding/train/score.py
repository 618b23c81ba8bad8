"""How well a model grounds: on pictures it was not trained on, through the run-time path."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from w2c.errors import ConfigError
from w2c_grounding.evidence import REGION_FRACTION, find, peak_point
from w2c_grounding.family import Family
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import load
from w2c_grounding.train.asker import Asker
from w2c_grounding.train.data import (
    ObjectTruth,
    PictureTruth,
    cropped,
    read_identity,
    read_picture,
    read_truth,
    truth_files,
)
from w2c_grounding.train.phrases import PhraseKind, fitting, phrases_by_kind

ABSENT_PER_PICTURE = 6
MOST_PHRASES = 16
"""Asked at once: a heatmap of 1280 x 720 takes 4 MB"""


@dataclass(frozen=True)
class Trial:
    """One phrase asked about one picture."""

    phrase: str
    phrase_kind: PhraseKind | None
    """How it names what it means; None where it fits nothing"""
    kind: str
    """Of the object that was asked for; empty where nothing fits"""
    unseen_kind: bool
    """The kind was never trained on"""
    unseen_pair: bool
    """The kind was never trained on in this colour, or of this material"""
    score: float
    """Peak of the heatmap"""
    peak_hits: bool
    """The arg-max lies on an object that the phrase fits"""
    interior_hits: bool
    """The point of the default rule does"""
    error: float
    """From the arg-max to the nearest pixel of such an object [px]; NaN where nothing fits"""


def score_model(
    model: str,
    directory: Path,
    *,
    seed: int = 0,
    threads: int = 2,
    report: Callable[[str], None] = lambda _: None,
) -> tuple[list[Trial], float, str]:
    """Ask a checkpoint about every picture of a directory.

    Returns:
        The trials, the threshold, and the name of the model.

    Raises:
        ConfigError: there are no pictures, or one is damaged.
        ModelError: the checkpoint is damaged.
    """
    family, card = load(ModelConfig(model=model, threads=threads))
    trials = run_trials(family, truth_files(directory), seed, report, edge=card.edge)
    return trials, card.threshold, card.name


def run_trials(
    family: Family[Any],
    files: Sequence[Path],
    seed: int,
    report: Callable[[str], None] = lambda _: None,
    *,
    edge: float = REGION_FRACTION,
) -> list[Trial]:
    """Ask for every clearly visible object in every way that fits it, and for absent things.

    A thing ends in a heatmap at the share `edge` of the peak.
    """
    truths = [read_truth(path) for path in files]
    asker = Asker(truths)
    rng = np.random.default_rng([seed, 31])
    trials: list[Trial] = []
    for number, (path, truth) in enumerate(zip(files, truths, strict=True), start=1):
        seen = {item.id: item.visible_pixels for item in truth.objects}
        shown = cropped(truth, truth.width, truth.height, seen)
        asked = list(_present(shown, rng))
        absent = [asker.absent(shown, rng) for _ in range(ABSENT_PER_PICTURE)]
        asks = [*asked, *((text, None, None) for text in absent)]
        trials += _ask(family, path, shown, asks, edge)
        if number % 50 == 0:
            report(f"{number} of {len(files)} pictures")
    return trials


Ask = tuple[str, PhraseKind | None, ObjectTruth | None]


def _ask(
    family: Family[Any], path: Path, truth: PictureTruth, asks: Sequence[Ask], edge: float
) -> Iterable[Trial]:
    image = read_picture(path, truth)
    owners = read_identity(path, truth)
    context = family.prepare(image)
    for first in range(0, len(asks), MOST_PHRASES):
        some = asks[first : first + MOST_PHRASES]
        evidence = family.query(context, [text for text, _, _ in some])
        for (text, phrase_kind, item), one in zip(some, evidence, strict=True):
            finding = find(one.heatmap, 0.0, boxes=one.boxes, edge=edge)
            wanted = np.isin(owners, fitting(truth, text)) if item is not None else None
            peak = peak_point(one.heatmap)
            yield Trial(
                phrase=text,
                phrase_kind=phrase_kind,
                kind="" if item is None else item.kind,
                unseen_kind=item is not None and item.held_out_kind,
                unseen_pair=item is not None and (item.held_out or item.held_out_material),
                score=finding.score,
                peak_hits=_on(wanted, peak),
                interior_hits=_on(wanted, finding.point),
                error=_distance(wanted, peak),
            )


def _present(truth: PictureTruth, rng: np.random.Generator) -> Iterable[Ask]:
    """Yield one phrase of each phrase kind for each thing that can be seen clearly."""
    for item in truth.clearly_visible():
        for phrase_kind, phrases in sorted(phrases_by_kind(truth, item).items()):
            yield phrases[int(rng.integers(len(phrases)))], phrase_kind, item


Wanted = np.ndarray[Any, np.dtype[np.bool_]] | None


def _on(wanted: Wanted, point: tuple[float, float] | None) -> bool:
    if wanted is None or point is None:
        return False
    return bool(wanted[int(point[1]), int(point[0])])


def _distance(wanted: Wanted, point: tuple[float, float]) -> float:
    """Return how far a point is from the nearest wanted pixel [px], 0 on one."""
    if wanted is None:
        return float("nan")
    if _on(wanted, point):
        return 0.0
    rows, columns = np.nonzero(wanted)
    return float(np.hypot(columns + 0.5 - point[0], rows + 0.5 - point[1]).min())


def calibrate(trials: Sequence[Trial], wanted_rejection: float = 0.92) -> float:
    """Return the threshold: the lowest that turns down this share of absent phrases.

    A thing that is not there must not be leaned on, so that rejection comes first; what remains
    goes to finding. Kept away from 0 and 1, where rounding of half-precision weights would
    decide.
    """
    absent = sorted(trial.score for trial in trials if not trial.kind)
    if not absent:
        raise ConfigError("no absent phrase was asked for; calibration needs pictures of objects")
    threshold = float(np.quantile(absent, wanted_rejection))
    return round(min(0.9, max(0.1, threshold + 0.005)), 3)


def summarise(trials: Sequence[Trial], threshold: float) -> dict[str, tuple[float, int]]:
    """Return rates from 0 to 1, or medians, by name, each with the number of trials behind it.

    `hit`, `interior_hit`, `found` and `found_and_hit` are of phrases that fit something; those of
    kinds, and of pairs of kind and colour or material, that training never saw have names of their
    own and count nowhere else.
    """
    present = [trial for trial in trials if trial.kind]
    absent = [trial for trial in trials if not trial.kind]
    seen = [trial for trial in present if not trial.unseen_kind and not trial.unseen_pair]
    groups: dict[str, list[Trial]] = {
        "": seen,
        ".unseen_kind": [trial for trial in present if trial.unseen_kind],
        ".unseen_pair": [t for t in present if t.unseen_pair and not t.unseen_kind],
    }
    result: dict[str, tuple[float, int]] = {}
    for name, group in groups.items():
        result[f"hit{name}"] = _rate(trial.peak_hits for trial in group)
        result[f"interior_hit{name}"] = _rate(trial.interior_hits for trial in group)
        result[f"found{name}"] = _rate(trial.score >= threshold for trial in group)
        result[f"found_and_hit{name}"] = _rate(
            trial.peak_hits and trial.score >= threshold for trial in group
        )
        for phrase_kind in sorted({str(trial.phrase_kind) for trial in group}):
            of_kind = [trial.peak_hits for trial in group if trial.phrase_kind == phrase_kind]
            result[f"hit{name}.phrase.{phrase_kind}"] = _rate(of_kind)
    result["absent_rejected"] = _rate(trial.score < threshold for trial in absent)
    errors = [trial.error for trial in seen]
    result["error_px_p90"] = (
        (float(np.quantile(errors, 0.9)) if errors else float("nan")),
        len(errors),
    )
    for kind in sorted({trial.kind for trial in seen}):
        result[f"hit.kind.{kind}"] = _rate(t.peak_hits for t in seen if t.kind == kind)
    return result


def _rate(hits: Iterable[bool]) -> tuple[float, int]:
    values = list(hits)
    return (round(sum(values) / len(values), 4) if values else float("nan")), len(values)
