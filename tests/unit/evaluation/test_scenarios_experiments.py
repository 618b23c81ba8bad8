"""The four experiments: the paper's prompts, and the places that they mean."""

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from w2c.errors import ConfigError
from w2c.library import library
from w2c_evaluation.scenarios.experiments import EXPERIMENTS
from w2c_evaluation.scenarios.phrase_book import PhraseBook
from w2c_evaluation.scenarios.scenario import Meaning, Place, Prompt, read_scenario, side_of

PROMPTS = {
    "a": ("Place your right hand on top of the book", "with your left hand, reach for the cup"),
    "b": (
        "Using your right hand, lean on top of the white surface",
        "reach for the red plate, with the left hand",
    ),
    "c": (
        "Place your right hand right from the thing with the wooden handle",
        "Reach for the nail box, with your left hand",
    ),
    "d": (
        "Place your right hand on the white cloth",
        "with the left hand, reach the cheez it box",
    ),
}
"""Verbatim"""


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Any, Path]]:
    """Make each scene once, without the checks that saving one makes: they take a second."""
    directory = tmp_path_factory.mktemp("scenes")
    made = {}
    for name in EXPERIMENTS:
        path = directory / f"{name}.json"
        made[name] = library("named_scene")(f"scenario_{name}", 3), path
        path.write_bytes(msgspec.json.encode(made[name][0]))
    return made


@pytest.mark.parametrize("name", PROMPTS)
def test_the_prompts_are_the_papers_and_mean_a_place_in_the_scene(
    name: str, scenes: dict[str, tuple[Any, Path]]
) -> None:
    scene, path = scenes[name]
    scenario = EXPERIMENTS[name].read(path)
    assert tuple(prompt.text for prompt in scenario.prompts) == PROMPTS[name]
    assert [p.meaning.task for p in scenario.prompts] == ["contact", "reach"]
    assert [p.meaning.effector for p in scenario.prompts] == ["right_hand", "left_hand"]
    book = PhraseBook({item.name: item.phrases() for item in scene.objects}, scenario.phrases())
    names = {item.name for item in scene.objects}
    for prompt in scenario.prompts:
        assert {prompt.place.thing, *prompt.place.surfaces, *prompt.touches} <= names
        for words, thing in prompt.meaning.things.items():
            assert book.find(words) == [thing]


@pytest.mark.parametrize("name", PROMPTS)
def test_only_the_mallet_is_a_thing_to_be_beside(
    name: str, scenes: dict[str, tuple[Any, Path]]
) -> None:
    first, last = EXPERIMENTS[name].read(scenes[name][1]).prompts
    assert last.meaning.position == "absolute"
    place = ("relative", "right", ("table",)) if name == "c" else ("absolute", None)
    found = first.meaning.position, first.meaning.side, first.place.surfaces
    assert found[: len(place)] == place


@pytest.mark.parametrize(
    ("beside", "side"),
    [
        ((0.0, 0.0, 0.0), None),
        ((0.0, -0.2, 0.0), "right"),
        ((0.0, 0.2, 0.0), "left"),
        ((0.2, 0.1, 0.0), "behind"),
        ((-0.2, 0.1, 0.0), "front"),
    ],
)
def test_sides_are_those_of_the_picture(
    beside: tuple[float, float, float], side: str | None
) -> None:
    assert side_of(beside) == side


@settings(max_examples=50)
@given(st.integers(0, 2**32), st.floats(0.0, 0.3))
def test_a_place_is_drawn_within_its_spread(seed: int, spread: float) -> None:
    place = Place("middle", "book", spread=(spread, 0.0, 0.0))
    drawn = place.drawn(np.random.default_rng(seed))
    assert abs(drawn.share[0]) <= spread
    assert drawn.share[1:] == (0.0, 1.0)
    assert drawn.drawn(np.random.default_rng(seed)) == drawn
    aim = drawn.aim(np.eye(4), (0.4, 0.2, 0.1))
    assert aim == pytest.approx((0.4 * drawn.share[0], 0.0, 0.1))


def test_a_scene_without_instructions_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    path.write_text('{"name": "empty", "instructions": []}')
    with pytest.raises(ConfigError, match="no instructions"):
        read_scenario("a", path)
    path.write_text("{")
    with pytest.raises(ConfigError, match="cannot be played"):
        read_scenario("a", path)
    with pytest.raises(ConfigError, match="cannot be played"):
        read_scenario("a", tmp_path / "missing.json")


def test_words_must_be_in_the_prompt() -> None:
    meaning = Meaning("left_hand", "reach", "absolute", {"red cup": "cup"})
    with pytest.raises(ConfigError, match="'red cup' is not in the prompt"):
        Prompt("reach for the cup", meaning, Place("cup", "cup"))
