"""What can be asked about a picture: a place, words for it, and its accepted area."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from w2c_evaluation.benchmark import areas
from w2c_evaluation.benchmark.naming import Naming, namings, told_apart
from w2c_evaluation.benchmark.plan import Slot
from w2c_evaluation.benchmark.sentences import Sentence, Task, instruct
from w2c_evaluation.benchmark.sight import Mask, Sight, Thing

LEAST_DISTRACTORS = 4
SMALLEST_AREA = {"absolute": 0.002, "relative": 0.004}
LARGEST_AREA = 0.20
"""Of the picture: a larger one is hit by chance"""
SMALLEST_PIECE = 150
"""A smaller piece of an area is dust between edges [px of 1280 x 720]"""
STURDY_KINDS = frozenset({"box", "block"})
"""Beside what carries: a person would lean on them. Not on a crate: it is open, and its rim is no
place to stand on."""
TALL_M = 0.06
GAP_PX = (50, 520)
"""Between two things"""
DISTANCES_CM = (5, 10, 15)
BESIDE = ("left", "right", "left", "right", "front", "behind", "next", "between", "between")
ENDS = ("end_left", "end_right", "end_front", "end_behind")
MEASURED = ("measured_left", "measured_right")
AREAS: dict[str, Callable[[Sight, Thing], Mask]] = {
    "on": areas.on,
    "on_top": areas.on_top,
    "next": areas.next_to,
}


@dataclass(frozen=True)
class Offer:
    """A prompt about a picture."""

    relation: str
    things: tuple[Thing, ...]
    """In order of mention"""
    names: tuple[Naming, ...]
    mask: Mask
    sentence: Sentence
    distractors: int


def offer(
    sight: Sight, slot: Slot, rng: np.random.Generator, *, unseen: bool = False
) -> Offer | None:
    """Return a prompt of a slot about a picture; None where there is none.

    Args:
        sight: The picture.
        slot: What the prompt shall be.
        rng: Source of chance.
        unseen: The first thing is one that no training shows; else none of the things is.
    """
    clear = sight.clear()
    whole = [thing for thing in clear if not (sight.cut_off(thing) or sight.hidden(thing))]
    if not unseen:
        whole = [thing for thing in whole if not thing.never_trained_on]
    for index in rng.permutation(len(whole)):
        thing = whole[int(index)]
        if unseen and not thing.never_trained_on:
            continue
        if slot.pair and not has_twin(thing, clear):
            continue
        name = _choose_name(namings(thing, sight.seen()), slot, rng)
        if name is None:
            continue
        places = _absolute if slot.position == "absolute" else _relative
        for relation, task, others in places(thing, whole, slot, rng):
            found = _complete(sight, relation, task, (thing, *others), name, slot, rng)
            if found is not None and found.distractors >= LEAST_DISTRACTORS:
                return found
    return None


def has_twin(thing: Thing, clear: Sequence[Thing]) -> bool:
    """Whether another of its kind is clearly seen, which something tells apart from it."""
    twins = (other for other in clear if other.kind == thing.kind and other.name != thing.name)
    return any(told_apart(thing, other) for other in twins)


def _choose_name(found: Sequence[Naming], slot: Slot, rng: np.random.Generator) -> Naming | None:
    """Return words that a slot allows: first a way to name things, so that all ways occur."""
    fit = [naming for naming in found if slot.plain or naming.how != "plain"]
    if slot.plain:
        fit = [naming for naming in fit if naming.how == "plain"] or fit
    ways = sorted({naming.how for naming in fit})
    if not ways:
        return None
    way = str(rng.choice(ways))
    of_way = [naming for naming in fit if naming.how == way]
    return of_way[int(rng.integers(len(of_way)))]


Place = tuple[str, Task, tuple[Thing, ...]]


def _absolute(
    thing: Thing, whole: Sequence[Thing], slot: Slot, rng: np.random.Generator
) -> Iterator[Place]:
    """Yield places on a thing."""
    del whole
    sturdy = _sturdy(thing)
    if slot.limb == "foot" or (sturdy and rng.random() < 0.7):
        if sturdy:
            tall = thing.top - thing.foot > TALL_M
            relation = "on_top" if tall or rng.random() < 0.4 else "on"
            yield relation, "contact", ()
        return
    yield "on", "reach", ()


def _relative(
    thing: Thing, whole: Sequence[Thing], slot: Slot, rng: np.random.Generator
) -> Iterator[Place]:
    """Yield places beside a thing, between it and another one, or at one of its ends."""
    task: Task = "contact" if slot.limb == "foot" or rng.random() < 0.8 else "reach"
    flat = _sturdy(thing) and thing.top - thing.foot < TALL_M
    known = [*BESIDE, *MEASURED, *(ENDS if flat else ())]
    for index in rng.permutation(len(known)):
        relation = known[int(index)]
        if relation != "between":
            yield relation, task, ()
            continue
        for other in (whole[int(i)] for i in rng.permutation(len(whole))):
            if other.name != thing.name and _has_gap(thing, other):
                yield relation, task, (other,)


def _sturdy(thing: Thing) -> bool:
    return thing.upright and (thing.support == "carries" or thing.kind in STURDY_KINDS)


def _has_gap(one: Thing, other: Thing) -> bool:
    """Whether there is room between two things that stand on the same surface."""
    gaps = [max(one.edges[i], other.edges[i]) - min(one.edges[i + 2], other.edges[i + 2])
            for i in (0, 1)]  # fmt: skip
    return abs(one.foot - other.foot) < 0.01 and GAP_PX[0] <= max(gaps) <= GAP_PX[1]


def _complete(
    sight: Sight,
    relation: str,
    task: Task,
    things: tuple[Thing, ...],
    name: Naming,
    slot: Slot,
    rng: np.random.Generator,
) -> Offer | None:
    """Return the prompt of a place, unless its area is too small, too large, or has no name."""
    names = [name]
    for other in things[1:]:
        second = _choose_name(namings(other, sight.seen()), slot, rng)
        if second is None:
            return None
        names.append(second)
    distance = int(rng.choice(DISTANCES_CM))
    mask = without_dust(area_of(sight, relation, things, distance))
    if not SMALLEST_AREA[slot.position] <= mask.mean() <= LARGEST_AREA:
        return None
    words = tuple(naming.text for naming in names)
    sentence = instruct(relation, words, slot.limb, task, distance, rng)
    spoken = {thing.name for thing in things}
    distractors = sum(thing.name not in spoken for thing in sight.clear())
    return Offer(relation, things, tuple(names), mask, sentence, distractors)


def area_of(sight: Sight, relation: str, things: Sequence[Thing], distance_cm: int) -> Mask:
    """Return the accepted area (h, w) of a relation to things."""
    thing = things[0]
    form, _, side = relation.rpartition("_")
    if relation in AREAS:
        area = AREAS[relation](sight, thing)
    elif relation == "between":
        area = areas.between(sight, thing, things[1])
    elif form == "end":
        area = areas.end_of(sight, thing, side)
    elif form == "measured":
        area = areas.measured(sight, thing, side, 0.01 * distance_cm)
    else:
        area = areas.beside(sight, thing, side)
    return area


def without_dust(mask: Mask) -> Mask:
    """Return a mask without the pieces that nobody would draw."""
    least = SMALLEST_PIECE * mask.size / (1280 * 720)
    count, labels, statistics, _ = cv2.connectedComponentsWithStats(
        mask.astype(np.uint8), connectivity=8
    )
    large = [i for i in range(1, count) if statistics[i, cv2.CC_STAT_AREA] >= least]
    return np.asarray(np.isin(labels, large), dtype=np.bool_)
