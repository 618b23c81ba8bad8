"""Figures of a benchmark, and the limits that keep it from being easy."""

from collections import Counter
from collections.abc import Sequence

import msgspec

from w2c_evaluation.benchmark.record import POSITIONS, Record

MOST_RANDOM = 0.17
LEAST_AVOIDING = 0.40
LEAST_PAIRS = 0.30
LEAST_DISTRACTORS = 4
LEAST_OUTDOORS = 0.2
MOST_OUTDOORS = 0.8
LEAST_FEET = 0.05
MOST_VERBS = 10
PICTURES_PER_VERB = 4


class Figures(msgspec.Struct, frozen=True, kw_only=True):
    """What a benchmark is like."""

    pictures: int
    absolute: int
    relative: int
    random: dict[str, float]
    """How often a random point hits, by position and overall: mean share of the masks"""
    avoiding: float
    """Share of prompts that name nothing by its usual name"""
    namings: dict[str, int]
    """How the first thing is named"""
    pairs: float
    """Share of pictures with two of a kind that an attribute tells apart"""
    asked_pairs: float
    """Share of prompts about one of two of a kind"""
    distractors: int
    """The fewest in a picture"""
    distractors_mean: float
    outdoors: float
    feet: float
    verbs: dict[str, int]
    relations: dict[str, int]
    held_out: float
    """Share of prompts about something that no picture for training shows"""


def figures_of(records: Sequence[Record], shares: Sequence[float]) -> Figures:
    """Return the figures of records that `benchmark make` made.

    Args:
        records: All with an origin.
        shares: Of each picture that its mask accepts.
    """
    origins = [record.origin for record in records if record.origin is not None]
    count = len(origins)
    by_position: dict[str, list[float]] = {
        name: [s for r, s in zip(records, shares, strict=True) if r.position == name]
        for name in POSITIONS
    }
    random = {name: round(mean(values), 4) for name, values in by_position.items()}
    random["overall"] = round(mean(shares), 4)
    return Figures(
        pictures=count,
        absolute=len(by_position["absolute"]),
        relative=len(by_position["relative"]),
        random=random,
        avoiding=sum(origin.naming != "plain" for origin in origins) / count,
        namings=dict(sorted(Counter(origin.naming for origin in origins).items())),
        pairs=sum(origin.pair for origin in origins) / count,
        asked_pairs=sum(bool(origin.attribute) for origin in origins) / count,
        distractors=min(origin.distractors for origin in origins),
        distractors_mean=mean([origin.distractors for origin in origins]),
        outdoors=sum(origin.look == "outdoor" for origin in origins) / count,
        feet=sum(origin.end_effector.endswith("foot") for origin in origins) / count,
        verbs=dict(Counter(origin.verb for origin in origins).most_common()),
        relations=dict(Counter(origin.relation for origin in origins).most_common()),
        held_out=sum(origin.held_out for origin in origins) / count,
    )


def missed(figures: Figures) -> list[str]:
    """Return the limits that a benchmark does not keep, for people."""
    verbs = min(MOST_VERBS, figures.pictures // PICTURES_PER_VERB)
    least_feet = int(LEAST_FEET * figures.pictures) / max(1, figures.pictures)
    rows: list[tuple[bool, str]] = [
        (
            abs(figures.absolute - figures.relative) <= 1,
            f"{figures.absolute} absolute and {figures.relative} relative, expected halves",
        ),
        (
            figures.avoiding >= LEAST_AVOIDING,
            f"{figures.avoiding:.2f} of the prompts avoid the usual name, expected "
            f"{LEAST_AVOIDING} or more",
        ),
        (
            figures.pairs >= LEAST_PAIRS,
            f"{figures.pairs:.2f} of the pictures hold two of a kind, expected {LEAST_PAIRS} "
            "or more",
        ),
        (
            figures.distractors >= LEAST_DISTRACTORS,
            f"a picture has {figures.distractors} distractors, expected {LEAST_DISTRACTORS} or "
            "more",
        ),
        (
            LEAST_OUTDOORS <= figures.outdoors <= MOST_OUTDOORS,
            f"{figures.outdoors:.2f} of the pictures look outdoors, expected {LEAST_OUTDOORS} to "
            f"{MOST_OUTDOORS}",
        ),
        (
            figures.feet >= least_feet,
            f"{figures.feet:.2f} of the prompts are for a foot, expected {LEAST_FEET} or more",
        ),
        (
            len(figures.verbs) >= verbs,
            f"{len(figures.verbs)} verbs, expected {verbs} or more",
        ),
    ]
    rows += [
        (
            value <= MOST_RANDOM,
            f"random points hit {value:.3f} ({name}), expected {MOST_RANDOM} at most",
        )
        for name, value in figures.random.items()
    ]
    return [text for kept, text in rows if not kept]


def mean(values: Sequence[float]) -> float:
    """Return the mean, 0 of nothing."""
    return sum(values) / len(values) if values else 0.0
