"""How well a model grounds: on pictures it was not trained on, through the run-time path."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from w2c.errors import ConfigError
from w2c_grounding.evidence import find, peak_point
from w2c_grounding.family import Family
from w2c_grounding.picture import decode
from w2c_grounding.train.data import ObjectTruth, PictureTruth, read_identity, read_truth
from w2c_grounding.train.phrases import Asker, fitting

ABSENT_PER_PICTURE = 4


@dataclass(frozen=True)
class Trial:
    """One phrase asked about one picture."""

    phrase: str
    kind: str
    """Of the object that was asked for; empty where nothing fits"""
    held_out: bool
    """The pair of kind and colour was never seen in training, and the phrase names the colour"""
    score: float
    """Peak of the heatmap"""
    peak_hits: bool
    """The arg-max lies on an object that the phrase fits"""
    interior_hits: bool
    """The point of the default rule does"""


def run_trials(family: Family[Any], files: Sequence[Path], seed: int) -> list[Trial]:
    """Ask for every clearly visible object, bare and with its colour, and for absent ones."""
    truths = [read_truth(path) for path in files]
    asker = Asker(truths, frozenset())
    rng = np.random.default_rng([seed, 31])
    trials: list[Trial] = []
    for path, truth in zip(files, truths, strict=True):
        asked = list(_present(truth, rng))
        absent = [asker.absent(truth, rng) for _ in range(ABSENT_PER_PICTURE)]
        phrases = [phrase for phrase, _ in asked] + absent
        try:
            image = decode((path.parent / truth.image).read_bytes())
        except OSError as error:
            raise ConfigError(f"picture of {path}: {error}; render this picture again") from error
        owners = read_identity(path, truth)
        evidence = family.query(family.prepare(image), phrases)
        items: list[ObjectTruth | None] = [item for _, item in asked]
        items += [None] * len(absent)
        for phrase, item, one in zip(phrases, items, evidence, strict=True):
            finding = find(one.heatmap, 0.0)
            ids = fitting(truth, phrase)
            trials.append(
                Trial(
                    phrase=phrase,
                    kind="" if item is None else item.kind,
                    held_out=item is not None and item.held_out and item.colour in phrase,
                    score=finding.score,
                    peak_hits=_owner(owners, peak_point(one.heatmap)) in ids,
                    interior_hits=_owner(owners, finding.point) in ids,
                )
            )
    return trials


def _present(truth: PictureTruth, rng: np.random.Generator) -> Iterable[tuple[str, ObjectTruth]]:
    for item in truth.clearly_visible():
        yield str(rng.choice(item.names)), item
        yield f"{item.colour} {rng.choice(item.names)}", item


def _owner(owners: np.ndarray[Any, Any], point: tuple[float, float] | None) -> int:
    return 0 if point is None else int(owners[int(point[1]), int(point[0])])


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


def summarise(trials: Sequence[Trial], threshold: float) -> dict[str, float]:
    """Return the scores by name: rates from 0 to 1, and the counts they are out of."""
    present = [trial for trial in trials if trial.kind]
    absent = [trial for trial in trials if not trial.kind]
    result = {
        "peak_pointing": _rate(trial.peak_hits for trial in present),
        "interior_pointing": _rate(trial.interior_hits for trial in present),
        "found": _rate(trial.score >= threshold for trial in present),
        "absent_rejected": _rate(trial.score < threshold for trial in absent),
        "present_phrases": float(len(present)),
        "absent_phrases": float(len(absent)),
        "held_out_pointing": _rate(trial.peak_hits for trial in present if trial.held_out),
    }
    for kind in sorted({trial.kind for trial in present}):
        of_kind = [trial for trial in present if trial.kind == kind]
        result[f"pointing.{kind}"] = _rate(trial.peak_hits for trial in of_kind)
    return result


def _rate(hits: Iterable[bool]) -> float:
    values = list(hits)
    return round(sum(values) / len(values), 4) if values else float("nan")
