"""Scenes as data: files, checks, scenario (a)."""

from pathlib import Path

import numpy as np
import pytest

from w2c.errors import ConfigError
from w2c_sim_robot.scenes import scene as scenes
from w2c_sim_robot.scenes.objects.catalogue import make_object
from w2c_sim_robot.scenes.scenario_a import BOOK_SIZE, random_layout, scenario_a
from w2c_sim_robot.scenes.scene import Instruction, Light, Scene
from w2c_sim_robot.scenes.wording import phrases_in

LAMP = Light(position=(0.0, 0.0, 3.0), direction=(0.0, 0.0, -1.0))


def test_a_scene_survives_the_file(tmp_path: Path) -> None:
    scene = scenario_a()

    scenes.save(scene, tmp_path / "a" / "scene.json")

    assert scenes.load(tmp_path / "a" / "scene.json") == scene


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no scene file at .*gone\.json"):
        scenes.load(tmp_path / "gone.json")


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("{", "scene.json"),
        ('{"name": "x", "objects": [], "lights": [], "colour": 1}', "unknown field `colour`"),
        ('{"name": "Bad Name", "objects": [], "lights": []}', r"\$\.name"),
        ('{"name": "x", "lights": []}', "missing required field `objects`"),
    ],
)
def test_a_bad_file_is_refused_with_its_field(tmp_path: Path, text: str, complaint: str) -> None:
    path = tmp_path / "scene.json"
    path.write_text(text)

    with pytest.raises(ConfigError, match=complaint):
        scenes.load(path)


def test_what_types_cannot_say_is_checked() -> None:
    mug = make_object("mug", "red", (0.0, 0.0, 0.0))
    cases = {
        "used twice": (mug, mug),
        "kind 'spaceship'": (_changed(mug, kind="spaceship"),),
        "colour 'ultraviolet'": (_changed(mug, colour="ultraviolet"),),
        "size": (_changed(mug, size=(0.1, 0.0, 0.1)),),
        "not finite": (_changed(mug, position=(0.0, float("nan"), 0.0)),),
        "unit quaternion": (_changed(mug, orientation=(0.0, 0.0, 0.0, 2.0)),),
    }

    for complaint, objects in cases.items():
        with pytest.raises(ConfigError, match=complaint):
            scenes.check(Scene(name="bad", objects=objects, lights=(LAMP,)))


def test_an_unknown_object_is_answered_with_the_known_ones() -> None:
    with pytest.raises(ConfigError, match=r"no object 'spoon'.*book, cup"):
        scenario_a(distractors=False).object("spoon")


def test_phrases_name_an_object_with_and_without_colour() -> None:
    phrases = make_object("mug", "red", (0.0, 0.0, 0.0)).phrases()

    assert phrases == ("cup", "mug", "red cup", "red mug", "ceramic cup")


def test_material_and_size_are_said_with_every_name_of_the_thing_but_not_of_what_is_in_it() -> None:
    shoe = make_object("shoe", "red", (0.0, 0.0, 0.0), material="leather", name="shoe_0")
    small = make_object("shoe", "red", (1.0, 0.0, 0.0), size=(0.1, 0.05, 0.05), name="shoe_1")
    nails = make_object("nail_box", "blue", (2.0, 0.0, 0.0))
    scene = (shoe, small, nails)

    assert {"leather sneaker", "red leather trainer", "large sneaker", "large red trainer"} <= set(
        phrases_in(shoe, scene)
    )
    assert {"cardboard box of nails", "blue nails"} <= set(phrases_in(nails, scene))
    assert "cardboard nails" not in phrases_in(nails, scene)


def test_the_pose_turns_about_the_vertical() -> None:
    book = make_object("book", "blue", (0.5, -0.2, 0.8), yaw=np.pi / 2)

    pose = book.world_from_object

    assert pose[:3, 3] == pytest.approx([0.5, -0.2, 0.8])
    assert pose[:3, :3] @ [1, 0, 0] == pytest.approx([0, 1, 0], abs=1e-9)


def test_in_scenario_a_the_book_is_fixed_on_the_table_and_the_cup_stands_free() -> None:
    scene = scenario_a(book_xy=(0.45, -0.3), cup_xy=(1.1, 0.2), table_height=0.75)

    book, cup = scene.object("book"), scene.object("cup")

    assert (book.movable, book.support) == (False, "carries")
    assert book.top_in_world == pytest.approx((0.45, -0.3, 0.75 + BOOK_SIZE[2]))
    assert (cup.movable, cup.position) == (True, (1.1, 0.2, 0.75))
    scenes.check(scene)


def test_scenario_a_refuses_what_would_fall_off_the_table() -> None:
    with pytest.raises(ConfigError, match=r"the cup at \(2, 0\.1\) m is not on the table"):
        scenario_a(cup_xy=(2.0, 0.1))


def test_random_layouts_keep_the_cup_in_the_band_and_differ() -> None:
    rng = np.random.default_rng(3)

    layouts = [random_layout(rng, (1.0, 1.1)) for _ in range(20)]

    assert all(1.0 <= layout.object("cup").position[0] <= 1.1 for layout in layouts)
    assert len({layout.object("book").position for layout in layouts}) == 20
    assert all(layout.object("book").colour != layout.object("cup").colour for layout in layouts)


def test_overlapping_bodies_are_refused_with_their_names_and_depth() -> None:
    table = make_object("table", "brown", (0.8, 0.0, 0.0))
    mug = make_object("mug", "red", (0.8, 0.0, table.size[2] - 0.03))
    sunk = make_object("ball", "blue", (0.0, 1.0, -0.02))
    cases = {
        "'table' and 'mug' overlap by 30 mm; at most 2 mm may": (table, mug),
        "'ball' and 'floor' overlap by 20 mm": (sunk,),
    }
    for complaint, objects in cases.items():
        with pytest.raises(ConfigError, match=complaint):
            scenes.check(Scene(name="bad", objects=objects, lights=(LAMP,)))
    # One that rests on the other is fine, and so is one that hangs beside it.
    resting = _changed(mug, position=(0.8, 0.0, table.size[2]))
    scenes.check(Scene(name="good", objects=(table, resting), lights=(LAMP,)))


def test_a_negative_size_in_a_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    scenes.save(scenario_a(), path)
    path.write_text(path.read_text().replace("0.27,", "-0.27,"))

    with pytest.raises(ConfigError, match=r"object 'book': size \(-0\.27, .* expected 0\.0005"):
        scenes.load(path)


def test_an_instruction_names_objects_that_are_there() -> None:
    instruction = Instruction(
        prompt="take it", end_effector="left_hand", task="reach", thing="spoon"
    )

    with pytest.raises(ConfigError, match="instruction 'take it': no object 'spoon'; it has: mug"):
        scenes.check(
            Scene(
                name="bad",
                objects=(make_object("mug", "red", (0.0, 0.0, 0.0)),),
                lights=(LAMP,),
                instructions=(instruction,),
            )
        )


def _changed(item: scenes.SceneObject, **fields: object) -> scenes.SceneObject:
    import msgspec

    return msgspec.structs.replace(item, **fields)
