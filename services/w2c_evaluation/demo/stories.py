"""The scenes that `w2c demo --scene` plays, and what is said in those that the paper has not.

(a) to (d) are the paper's experiments. In (e) a hand leans on a wall, so that a foot can be lifted;
in a random scene one thing is leaned on, or reached where nothing carries a hand.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from w2c.errors import ConfigError
from w2c.library import library
from w2c_evaluation.demo.lifted_foot import lift_left_foot
from w2c_evaluation.scenarios.experiments import EXPERIMENTS, Experiment
from w2c_evaluation.scenarios.eyewitness import Witness, find_place
from w2c_evaluation.scenarios.phrase_book import PhraseBook
from w2c_evaluation.scenarios.run import Afterwards
from w2c_evaluation.scenarios.scenario import Place

NEAR_M = (0.30, 0.56)
"""How far ahead a hand gets without a support"""
BROAD_M = 0.38
HIGH_M = (0.62, 1.15)
UPRIGHT = 0.95
"""Least z of the normal of what carries a hand"""
MOST_DRAWS = 20
SEEDS_APART = 1000


@dataclass(frozen=True)
class Story:
    """A scene with what is said in it, and what is done after the words."""

    experiment: Experiment
    afterwards: Afterwards | None = None


def draw_wall(seed: int, scene_path: Path) -> str:
    """Write the scene with the wall; only what can be said is left of its story."""
    scene = library("named_scene")("scenario_e", seed)
    spoken = tuple(step for step in scene.instructions if step.task != "lift")
    library("save_scene")(msgspec.structs.replace(scene, instructions=spoken), scene_path)
    return "scenario_e, as it comes from its seed; the foot is lifted by `release`, not by words"


def draw_random(seed: int, scene_path: Path) -> str:
    """Write the first random scene from a seed on in which a hand can do something.

    Raises:
        ConfigError: there is none in MOST_DRAWS.
    """
    for draw in range(MOST_DRAWS):
        scene = library("named_scene")("random", seed + draw * SEEDS_APART)
        instruction = instruction_for(library("witness")(scene))
        if instruction is None:
            continue
        library("save_scene")(scene, scene_path)
        told = json.loads(scene_path.read_bytes())
        scene_path.write_text(json.dumps({**told, "instructions": [instruction]}))
        return f"random scene of seed {scene.seed}: {instruction['description']}"
    raise ConfigError(
        f"nothing within reach in {MOST_DRAWS} random scenes of seed {seed}; choose another --seed"
    )


def instruction_for(witness: Witness) -> dict[str, Any] | None:
    """Return what to say in a scene: something to lean on, else something to reach, else None."""
    return next(_instructions(witness, leaning=True), None) or next(
        _instructions(witness, leaning=False), None
    )


def _instructions(witness: Witness, *, leaning: bool) -> Iterator[dict[str, Any]]:
    """Yield instructions about things that have a name of their own and are seen within reach."""
    things = witness.objects
    book = PhraseBook({item.name: item.phrases() for item in things}, {})
    for item in things:
        if leaning and item.support != "carries":
            continue
        place = find_place(witness, Place("", item.name))
        own = [phrase for phrase in item.phrases() if book.find(phrase) == [item.name]]
        if place is None or not own or (leaning and place.normal[2] < UPRIGHT):
            continue
        x, y, z = place.point.tolist()
        near = NEAR_M[0] <= x <= NEAR_M[1] and abs(y) <= BROAD_M and HIGH_M[0] <= z <= HIGH_M[1]
        if not near:
            continue
        side, phrase = "left" if y > 0.0 else "right", min(own, key=len)
        said = "Place your {} hand on the {}" if leaning else "With your {} hand, reach for the {}"
        yield {
            "prompt": said.format(side, phrase),
            "end_effector": f"{side}_hand",
            "task": "contact" if leaning else "reach",
            "things": {phrase: item.name},
            "thing": item.name,
            "description": f"the middle of the {phrase}",
        }


STORIES: dict[str, Story] = {
    **{name: Story(experiment) for name, experiment in EXPERIMENTS.items()},
    "e": Story(
        Experiment("e", "a hand on a wall, a foot lifted", draw_wall),
        Afterwards("the left foot was lifted, and held for 3 s", lift_left_foot),
    ),
    "random": Story(Experiment("random", "a random scene", draw_random)),
}


def find_story(name: str) -> Story:
    """Return the story of a scene. Raises ConfigError with the names there are."""
    if name not in STORIES:
        raise ConfigError(f"no scene '{name}' to play; choose of: {', '.join(STORIES)}")
    return STORIES[name]
