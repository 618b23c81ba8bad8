"""Scenes by chance: reproducible, apart, told apart, judged on what is never trained on."""

from itertools import combinations
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from w2c_sim_robot.scenes import scene as scenes
from w2c_sim_robot.scenes.assets import (
    SCENES_PER_STOCK,
    PaperScene,
    paper_scene_of,
    random_assets,
)
from w2c_sim_robot.scenes.held_out import (
    HELD_OUT_KINDS,
    JUDGING_SEED,
    held_out,
    held_out_material,
)
from w2c_sim_robot.scenes.objects.appliances import DOOR_TOP
from w2c_sim_robot.scenes.objects.catalogue import KINDS, MOVABLE_KINDS
from w2c_sim_robot.scenes.overlap import deepest_overlap
from w2c_sim_robot.scenes.placing import FLAT_KINDS, SMALL_KINDS
from w2c_sim_robot.scenes.random_scene import random_scene
from w2c_sim_robot.scenes.scene import Scene
from w2c_sim_robot.scenes.stages import STAGES
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


def like_paper(letter: PaperScene) -> list[Scene]:
    seeds = [seed for seed in range(4 * SCENES_PER_STOCK) if paper_scene_of(seed) == letter]
    return [random_scene(seed, paper_share=1.0) for seed in seeds[:20]]


def test_things_stand_on_tables_counters_shelves_and_floors(training: list[Scene]) -> None:
    plain = [scene for scene in training if stage_of(scene) in STAGES]
    plain = [scene for scene in plain if not any(o.kind == "dishwasher" for o in scene.objects)]
    assert {stage_of(scene) for scene in plain} == set(STAGES)
    for scene in plain:
        things = [item for item in scene.objects if not KINDS[item.kind].furniture]
        assert things
        if stage_of(scene) == "floor":
            continue
        furniture = scene.objects[0]
        for item in things:
            middle = item.world_from_object @ [0.0, 0.0, item.size[2] / 2, 1.0]
            away = np.abs(middle[:2] - furniture.position[:2])
            assert (away <= np.array(furniture.size[:2]) / 2).all(), (scene.seed, item.name)


@pytest.mark.parametrize("letter", get_args(PaperScene))
def test_a_share_of_the_scenes_holds_what_a_scene_of_the_paper_holds(letter: PaperScene) -> None:
    always = {"a": {"book", "mug"}, "b": {"counter", "dishwasher", "dish_rack", "plate"}}
    always |= {"c": {"table", "mallet"}, "d": {"fridge", "table"}}
    for scene in like_paper(letter):
        kinds = {item.kind for item in scene.objects}
        missing = always[letter] - kinds
        # A counter in place of the table, and now and then a thing that found no room.
        assert missing <= {"table"} or (letter in "ac" and len(missing) == 1), (scene.seed, kinds)


def test_a_plate_stands_in_the_rack_and_the_rack_on_the_door() -> None:
    for scene in like_paper("b"):
        rack = next(item for item in scene.objects if item.kind == "dish_rack")
        assert rack.position[2] == DOOR_TOP
        for plate in (item for item in scene.objects if item.kind == "plate"):
            upward = plate.world_from_object[:3, :3] @ [0.0, 0.0, 1.0]
            assert upward[0] < -0.9
            away = np.abs(np.subtract(plate.position, rack.position)[:2])
            half = np.array([0.0, plate.size[0] / 2])
            assert (away + half <= np.array(rack.size[:2]) / 2).all()


def test_a_cloth_hangs_over_the_front_of_most_fridges() -> None:
    scenes = like_paper("d")
    draped = 0
    for scene in scenes:
        fridge = scene.objects[0]
        for cloth in (item for item in scene.objects if item.kind == "drape"):
            draped += 1
            assert cloth.position[0] - cloth.size[0] / 2 < fridge.position[0] - fridge.size[0] / 2
            top = cloth.position[2] + cloth.size[2]
            assert fridge.size[2] < top < fridge.size[2] + 0.02
    assert 0.4 * len(scenes) < draped < len(scenes)


@pytest.mark.parametrize("letter", get_args(PaperScene))
def test_in_scenes_like_the_papers_nothing_is_inside_anything_else(letter: PaperScene) -> None:
    for scene in like_paper(letter)[:6]:
        assert deepest_overlap(scene.objects) is None, scene.seed


def test_a_scene_like_none_of_the_papers_is_the_same_whatever_else_is_in_stock() -> None:
    stocks = [random_assets(np.random.default_rng(5), paper_scene=one) for one in ("a", "b", "d")]
    assert len({len(stock) for stock in stocks}) == 3
    scenes = [random_scene(17, stock, 0.0).objects for stock in stocks]
    assert scenes[0] == scenes[1] == scenes[2]


def test_without_the_things_of_its_scene_a_seed_gives_one_like_a() -> None:
    assets = random_assets(np.random.default_rng(3), paper_scene="a")
    scene = random_scene(SCENES_PER_STOCK, assets, 1.0)
    assert not any(item.kind == "dishwasher" for item in scene.objects)
    assert any(item.kind == "mug" for item in scene.objects)


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


def test_a_scene_of_twins_has_two_of_each_kind_that_colour_does_not_tell_apart() -> None:
    scenes = [random_scene(seed, paper_share=0.0, twins_share=1.0) for seed in range(20000, 20030)]
    things = [[o for o in scene.objects if not KINDS[o.kind].furniture] for scene in scenes]
    pairs = [
        (one, other)
        for some in things
        for one, other in combinations(some, 2)
        if one.kind == other.kind
    ]
    one_colour = [pair for pair in pairs if pair[0].colour == pair[1].colour]
    of_another_material = [pair for pair in one_colour if pair[0].material != pair[1].material]

    # Where there is no room for the second of two, it stands alone.
    assert len(pairs) > 0.3 * sum(len(some) for some in things)
    assert len(one_colour) > 0.75 * len(pairs)
    assert len(of_another_material) > 0.3 * len(pairs)


def test_a_share_of_twins_leaves_the_other_scenes_as_they_are() -> None:
    seeds = range(20000, 20012)
    plain = [random_scene(seed, paper_share=0.0) for seed in seeds]
    some = [random_scene(seed, paper_share=0.0, twins_share=0.5) for seed in seeds]
    assert [random_scene(seed, paper_share=1.0, twins_share=1.0) for seed in seeds] == [
        random_scene(seed, paper_share=1.0) for seed in seeds
    ]
    same = [one == other for one, other in zip(plain, some, strict=True)]
    assert any(same)
    assert not all(same)
