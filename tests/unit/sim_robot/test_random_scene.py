"""Scenes by chance: reproducible, on the furniture, apart, judged on unseen pairs."""

from itertools import combinations

import numpy as np
import pytest

from w2c_sim_robot.scenes import scene as scenes
from w2c_sim_robot.scenes.objects.catalogue import KINDS, MOVABLE_KINDS
from w2c_sim_robot.scenes.random_scene import (
    FLAT_KINDS,
    JUDGING_SEED,
    held_out,
    random_assets,
    random_scene,
)

SEEDS = range(60)


def test_a_seed_always_gives_the_same_scene() -> None:
    assert random_scene(7) == random_scene(7)
    assert random_scene(7).objects != random_scene(8).objects


@pytest.mark.parametrize("seed", SEEDS)
def test_things_stand_on_furniture_and_not_in_one_another(seed: int) -> None:
    scene = random_scene(seed)
    furniture, *things = scene.objects
    scenes.check(scene)

    assert KINDS[furniture.kind].furniture
    for item in things:
        away = np.abs(np.subtract(item.position[:2], furniture.position[:2]))
        assert (away <= np.array(furniture.size[:2]) / 2).all()
    for a, b in combinations(things, 2):
        if a.position[2] == b.position[2]:
            distance = np.hypot(a.position[0] - b.position[0], a.position[1] - b.position[1])
            assert distance > max(min(a.size[:2]), min(b.size[:2])) / 2
        else:
            on_top = max(a, b, key=lambda item: item.position[2])
            below = a if on_top is b else b
            if on_top.position[:2] == below.position[:2]:
                assert below.kind in FLAT_KINDS


def test_two_of_a_kind_are_told_apart_by_colour_and_do_occur() -> None:
    pairs = 0
    for seed in SEEDS:
        for a, b in combinations(random_scene(seed).objects, 2):
            if a.kind == b.kind:
                pairs += 1
                assert a.colour != b.colour
    assert pairs > 10


def test_held_out_pairs_are_shown_in_judging_scenes_only() -> None:
    def share(first_seed: int) -> float:
        things = [
            held_out(item.kind, item.colour)
            for seed in range(first_seed, first_seed + 60)
            for item in random_scene(seed).objects
        ]
        return float(np.mean(things))

    assert share(0) == 0.0
    assert share(JUDGING_SEED) > 0.1


def test_every_kind_keeps_most_of_its_colours_for_training() -> None:
    for kind in MOVABLE_KINDS:
        reserved = [colour for colour in KINDS[kind].colours if held_out(kind, colour)]
        assert len(reserved) < len(KINDS[kind].colours)
    total = sum(held_out(k, c) for k in MOVABLE_KINDS for c in KINDS[k].colours)
    assert total >= 10


def test_a_scene_can_be_made_of_given_things_only() -> None:
    assets = random_assets(np.random.default_rng(0))
    known = {(asset.name, asset.kind, asset.size) for asset in assets}

    for seed in SEEDS:
        for item in random_scene(seed, assets).objects:
            assert (item.name, item.kind, item.size) in known
