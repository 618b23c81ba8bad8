"""Scenes by chance: reproducible, apart, told apart, judged on what is never trained on."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from w2c_sim_robot.scenes import scene as scenes
from w2c_sim_robot.scenes.assets import random_assets
from w2c_sim_robot.scenes.held_out import (
    HELD_OUT_KINDS,
    JUDGING_SEED,
    held_out,
    held_out_material,
)
from w2c_sim_robot.scenes.objects.catalogue import KINDS, MOVABLE_KINDS
from w2c_sim_robot.scenes.overlap import deepest_overlap
from w2c_sim_robot.scenes.placing import FLAT_KINDS, SMALL_KINDS
from w2c_sim_robot.scenes.random_scene import STAGES, random_scene
from w2c_sim_robot.scenes.scene import Scene
from w2c_sim_robot.scenes.wording import told_apart_by

COUNT = 120


@pytest.fixture(scope="module")
def training() -> list[Scene]:
    return [random_scene(seed) for seed in range(COUNT)]


@pytest.fixture(scope="module")
def judging() -> list[Scene]:
    return [random_scene(JUDGING_SEED + number) for number in range(COUNT)]


def stage_of(scene: Scene) -> str:
    first = scene.objects[0].kind
    return first if KINDS[first].furniture else "floor"


def test_a_seed_always_gives_the_same_scene() -> None:
    assert random_scene(7) == random_scene(7)
    assert random_scene(7).objects != random_scene(8).objects


def test_a_random_scene_can_be_kept_in_a_file(tmp_path: Path) -> None:
    scenes.save(random_scene(3), tmp_path / "scene.json")
    assert scenes.load(tmp_path / "scene.json") == random_scene(3)


def test_things_stand_on_tables_counters_shelves_and_floors(training: list[Scene]) -> None:
    assert {stage_of(scene) for scene in training} == set(STAGES)
    for scene in training:
        things = [item for item in scene.objects if not KINDS[item.kind].furniture]
        assert things
        if stage_of(scene) == "floor":
            continue
        furniture = scene.objects[0]
        for item in things:
            middle = item.world_from_object @ [0.0, 0.0, item.size[2] / 2, 1.0]
            away = np.abs(middle[:2] - furniture.position[:2])
            assert (away <= np.array(furniture.size[:2]) / 2).all(), (scene.seed, item.name)


def test_nothing_is_inside_anything_else(training: list[Scene]) -> None:
    crowded = sorted(training, key=lambda scene: -len(scene.objects))
    for scene in crowded[:4]:
        assert deepest_overlap(scene.objects) is None, scene.seed
    scenes.check(training[4])


def test_clutter_lying_things_and_things_on_things_occur(training: list[Scene]) -> None:
    assert max(len(scene.objects) for scene in training) >= 13
    things = [item for scene in training for item in scene.objects]
    assert any(abs(item.orientation[3]) < 0.9 and item.orientation[0] != 0 for item in things)
    stacked = 0
    for scene in training:
        for a, b in combinations(scene.objects, 2):
            if a.position[:2] == b.position[:2]:
                low, high = sorted((a, b), key=lambda item: item.position[2])
                assert low.kind in FLAT_KINDS and high.kind in SMALL_KINDS
                stacked += 1
    assert stacked >= 5


def test_two_of_a_kind_are_told_apart_by_an_attribute(training: list[Scene]) -> None:
    ways = [
        told_apart_by(a, b)
        for scene in training
        for a, b in combinations(scene.objects, 2)
        if a.kind == b.kind
    ]
    assert set(ways) == {"colour", "size", "material"}
    assert len(ways) > 20


def test_a_fifth_of_kinds_and_of_their_materials_is_kept_for_judging() -> None:
    assert set(KINDS) >= HELD_OUT_KINDS
    assert len(HELD_OUT_KINDS) >= 0.2 * len(KINDS)
    pairs = [
        (kind, material)
        for kind, row in KINDS.items()
        for material in row.materials
        if kind not in HELD_OUT_KINDS
    ]
    kept = [pair for pair in pairs if held_out_material(*pair)]
    assert 0.2 <= len(kept) / len(pairs) <= 0.35
    assert not any(held_out_material(kind, row.material) for kind, row in KINDS.items())


def test_training_scenes_never_show_what_is_kept_and_judging_scenes_do(
    training: list[Scene], judging: list[Scene]
) -> None:
    def shares(of: list[Scene]) -> list[float]:
        things = [item for scene in of for item in scene.objects]
        return [
            float(np.mean([item.kind in HELD_OUT_KINDS for item in things])),
            float(np.mean([held_out_material(item.kind, item.material) for item in things])),
            float(np.mean([held_out(item.kind, item.colour) for item in things])),
        ]

    assert shares(training) == [0.0, 0.0, 0.0]
    assert all(share > 0.03 for share in shares(judging))


def test_every_kind_keeps_most_of_its_colours_for_training() -> None:
    for kind in MOVABLE_KINDS:
        reserved = [colour for colour in KINDS[kind].colours if held_out(kind, colour)]
        assert len(reserved) < len(KINDS[kind].colours)
    total = sum(held_out(k, c) for k in MOVABLE_KINDS for c in KINDS[k].colours)
    assert total >= 10


def test_a_scene_can_be_made_of_given_things_only() -> None:
    assets = random_assets(np.random.default_rng(0))
    known = {(asset.name, asset.kind, asset.size, asset.material) for asset in assets}

    for seed in range(COUNT):
        for item in random_scene(seed, assets).objects:
            assert (item.name, item.kind, item.size, item.material) in known
