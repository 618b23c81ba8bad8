"""A benchmark is made as planned, the same for the same seed, and reads back sound."""

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from fakes.flat_world import HEIGHT, WIDTH, FlatWorld
from w2c.errors import ConfigError, W2CError
from w2c.library import library
from w2c_evaluation.benchmark import commands, make
from w2c_evaluation.benchmark.commands import main
from w2c_evaluation.benchmark.dataset import load, read
from w2c_evaluation.benchmark.make import FIRST_SCENE, Folder, Made, Manifest, fill
from w2c_evaluation.benchmark.sight import sight_of

COUNT = 16


def written(directory: Path, made: list[Made]) -> Manifest:
    folder = Folder(directory, (WIDTH, HEIGHT))
    for one in made:
        folder.add(one)
    return folder.finish(3)


@pytest.fixture(scope="module")
def made() -> list[Made]:
    return list(fill(FlatWorld(), 3, COUNT))


@pytest.fixture(scope="module")
def folder(made: list[Made], tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("benchmark") / "out"
    written(directory, made)
    return directory


def test_every_slot_gets_what_it_asked_for(made: list[Made]) -> None:
    assert sorted(one.slot.number for one in made) == list(range(COUNT))
    for one in made:
        slot, offer = one.slot, one.offer
        assert slot.limb == "hand" or one.stage == "floor"
        assert not slot.pair or offer.names[0].attribute
        assert slot.plain or all(naming.how != "plain" for naming in offer.names)
        assert offer.distractors >= 4
        assert (offer.relation in ("on", "on_top")) == (slot.position == "absolute")
        on_things = np.isin(one.sight.identity[offer.mask], [t.id for t in offer.things])
        inside = slot.position == "absolute" or offer.relation.startswith("end_")
        assert on_things.all() if inside else not on_things.any()


def test_what_no_training_shows_is_asked_for_only_where_that_is_wanted(made: list[Made]) -> None:
    everything = {thing.never_trained_on for one in made for thing in one.sight.clear()}
    assert everything == {True, False}
    assert not any(thing.never_trained_on for one in made for thing in one.offer.things)

    unseen = list(fill(FlatWorld(), 3, COUNT, unseen=True))
    assert len(unseen) == COUNT
    assert all(one.offer.things[0].never_trained_on for one in unseen)
    assert any(not one.offer.things[-1].never_trained_on for one in unseen)


def test_scenes_are_for_judging_and_none_is_used_twice(made: list[Made]) -> None:
    scenes = [one.scene for one in made]

    assert min(scenes) == FIRST_SCENE + 30_000
    assert len(set(scenes)) == COUNT
    assert max(np.bincount([(s - min(scenes)) // 50 for s in scenes])) <= 8


def test_the_folder_reads_back_sound_and_says_its_figures(folder: Path) -> None:
    assert read(folder)[1] == []
    manifest = msgspec.json.decode((folder / "benchmark.json").read_bytes(), type=Manifest)
    items = load(folder)

    assert manifest.figures.pictures == COUNT
    assert manifest.figures.absolute == manifest.figures.relative == COUNT / 2
    shares = [item.accepted().mean() for item in items]
    assert manifest.figures.random["overall"] == pytest.approx(np.mean(shares), abs=1e-4)
    assert {path.name for path in (folder / "overlays").iterdir()} == {
        f"{i:03d}.jpg" for i in range(COUNT)
    }
    assert (folder / "sheet.jpg").stat().st_size > 1000
    for item in items:
        # The things are seen from 1.2 m (on the table) or 2 m above their foot, in their middle.
        height = 2.0 if item.record.origin.stage == "floor" else 1.2  # type: ignore[union-attr]
        assert item.record.px_per_cm == pytest.approx(0.01 * 200.0 / (height - 0.02), abs=0.02)
        assert item.record.things is not None
        assert all(thing.words in item.record.prompt for thing in item.record.things)


def test_the_same_seed_gives_the_same_prompts_and_masks(folder: Path, tmp_path: Path) -> None:
    written(tmp_path / "again", list(fill(FlatWorld(), 3, COUNT)))

    for path in [folder / "prompts.jsonl", *sorted((folder / "masks").iterdir())]:
        assert (tmp_path / "again" / path.relative_to(folder)).read_bytes() == path.read_bytes()
    assert len(list((folder / "masks").iterdir())) == COUNT


def test_another_seed_gives_other_prompts(folder: Path) -> None:
    other = next(iter(fill(FlatWorld(), 4, 2)))

    assert other.scene >= FIRST_SCENE + 40_000
    assert other.offer.sentence.text not in {item.record.prompt for item in load(folder)}


def test_a_world_without_enough_things_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(make, "SCENES_PER_BENCHMARK", 100)
    monkeypatch.setattr(make, "_may_fill", lambda _scene, _slot: False)

    with pytest.raises(ConfigError, match="2 of 2 prompts found no picture"):
        list(fill(FlatWorld(), 0, 2))


def test_a_folder_that_holds_something_is_not_touched(tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("x")

    with pytest.raises(ConfigError, match="is not empty"):
        Folder(tmp_path, (WIDTH, HEIGHT))
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


def test_a_full_disk_is_told(
    made: list[Made], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = Folder(tmp_path / "out", (WIDTH, HEIGHT))

    def full(_path: Path, _data: bytes) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(W2CError, match="free some space"):
        folder.add(made[0])


def test_the_command_makes_prints_and_fails_where_it_is_easy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def offered(name: str) -> Any:
        return (lambda *_: FlatWorld()) if name == "true_pictures" else library(name)

    monkeypatch.setattr(commands, "library", offered)

    assert main(["make", "--out", str(tmp_path / "one"), "--count", "4"]) == 0
    monkeypatch.setattr("w2c_evaluation.benchmark.figures.MOST_RANDOM", 0.0)
    assert main(["make", "--out", str(tmp_path / "two"), "--count", "2"]) == 1
    said = capsys.readouterr().out
    assert "2 absolute, 2 relative; random points hit" in said
    assert "limit missed: random points hit" in said
    assert main(["check", str(tmp_path / "two")]) == 0
    assert "limit missed: random points hit" in capsys.readouterr().out
    assert main(["make", "--out", str(tmp_path / "two")]) == 2
    assert main(["make", "--out", str(tmp_path / "three"), "--count", "1"]) == 2


def test_the_simulator_shows_what_its_truth_says(monkeypatch: pytest.MonkeyPatch) -> None:
    """The only picture that is rendered here, small, and of few kinds: compiling takes time."""
    monkeypatch.setattr("w2c_sim_robot.scenes.assets.STOCK_KINDS", 6)
    pictures = library("true_pictures")(320, 180)
    try:
        with pytest.raises(ConfigError, match="training"):
            pictures.scene(5)
        scene = pictures.scene(FIRST_SCENE + 3)
        picture = pictures.draw(FIRST_SCENE + 3, outdoors=True)
    finally:
        pictures.close()
    sight = sight_of(picture)

    assert [thing.kind for thing in sight.things] == [item.kind for item in scene.objects]
    assert sight.clear()
    for thing in sight.clear():
        seen = sight.world[sight.identity == thing.id]
        low, high = thing.corners.min(axis=0), thing.corners.max(axis=0)
        assert np.nanmin(seen - low) > -0.02 and np.nanmax(seen - high) < 0.02, thing.name
    floor = sight.free_surface(0.0)
    assert floor.any() and not sight.identity[floor].any()
