"""Prompts around a place: verbs, hands and feet, courtesies, as different people say them."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

Task = Literal["contact", "reach"]

RELATIONS: dict[str, tuple[str, ...]] = {
    "on": ("on {A}", "onto {A}", "on {A}", "upon {A}"),
    "on_top": ("on top of {A}", "on the top of {A}", "right on top of {A}"),
    "left": ("left of {A}", "to the left of {A}", "left from {A}", "on the left of {A}"),
    "right": ("right of {A}", "to the right of {A}", "right from {A}", "on the right of {A}"),
    "behind": ("behind {A}", "beyond {A}", "in back of {A}"),
    "front": ("in front of {A}", "just in front of {A}", "before {A}"),
    "next": ("next to {A}", "beside {A}", "close to {A}", "near {A}", "right next to {A}"),
    "between": ("between {A} and {B}", "in between {A} and {B}", "halfway between {A} and {B}"),
    "end_left": (
        "on the left end of {A}", "on the left edge of {A}", "on the left part of {A}",
    ),
    "end_right": (
        "on the right end of {A}", "on the right edge of {A}", "on the right part of {A}",
    ),
    "end_front": ("on the near edge of {A}", "on the front part of {A}"),
    "end_behind": ("on the far edge of {A}", "on the back part of {A}"),
    "measured_left": ("{cm} cm to the left of {A}", "about {cm} centimeters left of {A}"),
    "measured_right": ("{cm} cm to the right of {A}", "about {cm} centimeters right of {A}"),
}  # fmt: skip
PUT = ("place", "put", "rest", "set", "press", "lay", "position", "plant", "keep")
LEAN = ("lean", "lean", "support yourself", "brace yourself", "push", "press", "steady yourself")
REACH = (
    "reach for {A}", "touch {A}", "grab {A}", "go for {A}", "take {A}", "pick up {A}",
    "reach out to {A}", "get {A}", "tap {A}",
)  # fmt: skip
REACH_PLACE = ("reach {place}", "touch the spot {place}", "point at the spot {place}")
STEP = ("step", "stand", "put your weight")
HANDS = ("hand", "hand", "hand", "palm", "arm")
FEET = ("foot", "foot", "foot", "sole", "leg")
COURTESIES = ("{s}, please", "now {s}", "ok, {s}")
BEFORE_A_VERB = ("please {s}", "could you {s}", "I want you to {s}")


@dataclass(frozen=True)
class Sentence:
    """A prompt and what a listener must make of it."""

    text: str
    verb: str
    end_effector: str
    task: Task


def instruct(
    relation: str,
    words: tuple[str, ...],
    limb: str,
    task: Task,
    distance_cm: int,
    rng: np.random.Generator,
) -> Sentence:
    """Return a prompt for a place.

    Args:
        relation: Of the place to the things: one of `RELATIONS`.
        words: For the things, without article, in order of mention.
        limb: hand or foot.
        task: contact or reach; of a thing itself, or of a place.
        distance_cm: Where the relation has one.
        rng: Chooses words and side.
    """
    side = str(rng.choice(["left", "right"]))
    noun = str(rng.choice(HANDS if limb == "hand" else FEET))
    member = f"your {side} {noun}"
    place = str(rng.choice(RELATIONS[relation])).replace("{cm}", str(distance_cm))
    verb, text = _clause(relation, place, member, limb, task, rng)
    for letter, word in zip("AB", words, strict=False):
        text = text.replace(f"{{{letter}}}", f"the {word}")
    if rng.random() < 0.25:
        courtesies = COURTESIES + (BEFORE_A_VERB if text.startswith(verb) else ())
        text = str(rng.choice(courtesies)).replace("{s}", text)
    return Sentence(_written(text, rng), verb, f"{side}_{limb}", task)


def _clause(
    relation: str, place: str, member: str, limb: str, task: Task, rng: np.random.Generator
) -> tuple[str, str]:
    """Return the verb, and the clause with letters for the things."""
    order = rng.random()
    if task == "reach":
        pattern = str(rng.choice(REACH if relation == "on" else REACH_PLACE))
        action = pattern.replace("{place}", place)
        verb = pattern.partition(" the spot")[0].partition(" {")[0]
        forms = (f"{action} with {member}", f"with {member}, {action}", f"{action} using {member}")
        return verb, forms[int(order * 3)]
    if limb == "foot" and order < 0.4:
        verb = str(rng.choice(STEP))
        return verb, f"{verb} {place} with {member}"
    if order < 0.55 or (limb == "foot" and order < 0.85):
        verb = str(rng.choice(PUT))
        return verb, f"{verb} {member} {place}"
    verb = "stand" if limb == "foot" else str(rng.choice(LEAN))
    texts = (f"using {member}, {verb} {place}", f"{verb} {place} with {member}")
    return verb, texts[int(rng.integers(2))]


def _written(text: str, rng: np.random.Generator) -> str:
    """Return a clause as people type it: with a capital and a full stop, or without."""
    manner = rng.random()
    if manner < 0.55:
        return text[0].upper() + text[1:]
    return text[0].upper() + text[1:] + "." if manner < 0.85 else text
