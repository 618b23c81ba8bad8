"""Pictures with truth, and the questions asked about them."""

from pathlib import Path

import numpy as np
import pytest
import torch

from fakes.rendered import write_pictures
from w2c.errors import ConfigError
from w2c_grounding.train import asker
from w2c_grounding.train.asker import FOREIGN, Asker, invented_word
from w2c_grounding.train.augment import draw_view, look, relight
from w2c_grounding.train.data import (
    ObjectTruth,
    PartTruth,
    PictureTruth,
    cropped,
    read_truth,
    truth_files,
)
from w2c_grounding.train.phrases import (
    could_fit,
    fitting,
    kind_of,
    phrases_by_kind,
)
from w2c_grounding.train.pictures import open_pictures
from w2c_grounding.train.uses import EVERY_USE
from w2c_grounding.train.vocabulary import tokenizer_words, vocabulary_of
from w2c_grounding.wording import words


def thing(number: int, kind: str, colour: str, *names: str, pixels: int = 5000) -> ObjectTruth:
    phrases = (*names, *(f"{colour} {name}" for name in names))
    return ObjectTruth(number, kind, colour, names, phrases, pixels)


def scene(*objects: ObjectTruth) -> PictureTruth:
    return PictureTruth("0.jpg", "0_identity.png", 640, 360, 0, objects)


TABLE = scene(
    thing(1, "book", "red", "book", "hardcover"),
    thing(2, "mug", "blue", "cup", "mug"),
    thing(3, "mug", "green", "cup", "mug"),
    thing(4, "cereal_box", "yellow", "cereal box", "packet"),
    thing(5, "apple", "red", "apple", pixels=20),  # hardly to be seen
)


# A wooden spatula among others of its kind, and a thing whose handle nobody said anything about.
TOOLS = scene(
    ObjectTruth(
        1,
        "brush",
        "red",
        ("brush", "hair brush"),
        (
            "brush",
            "hair brush",
            "red brush",
            "red hair brush",
            "wood brush",
            "wooden brush",
            "red wooden brush",
            "large brush",
            "large red brush",
            "thing with the wooden handle",
        ),
        9000,
        "wood",
        (PartTruth("handle"),),
    ),
    ObjectTruth(
        2,
        "brush",
        "blue",
        ("brush", "hair brush"),
        (
            "brush",
            "hair brush",
            "blue brush",
            "blue hair brush",
            "plastic brush",
            "blue plastic brush",
            "small brush",
            "small blue brush",
        ),
        6000,
        "plastic",
        (PartTruth("bristles"),),
    ),
    ObjectTruth(
        3, "cup", "white", ("cup",), ("cup", "white cup"), 5000, "", (PartTruth("handle"),)
    ),
)


def test_pictures_are_squashed_once_with_their_identities(tmp_path: Path) -> None:
    files = write_pictures(tmp_path / "data", 3)
    assert truth_files(tmp_path / "data") == files
    kept = tmp_path / "kept"
    pictures = open_pictures(files, 48, kept, threads=2)
    assert pictures.pixels.shape == (3, 48, 48, 3)
    assert pictures.identities.shape == (3, 48, 48)
    for truth, pixels, owners in zip(
        pictures.truths, pictures.pixels, pictures.identities, strict=True
    ):
        assert set(np.unique(owners)) == {0, *(item.id for item in truth.objects)}
        for item in truth.objects:
            channel = ("red", "green", "blue").index(item.colour)
            assert pixels[owners == item.id].mean(axis=0).argmax() == channel
    written = (kept / "pixels.u8").stat().st_mtime_ns
    open_pictures(files, 48, kept)
    assert (kept / "pixels.u8").stat().st_mtime_ns == written
    assert open_pictures(files[:2], 48, kept).pixels.shape == (2, 48, 48, 3)


def test_pictures_of_an_interrupted_writing_are_written_again(tmp_path: Path) -> None:
    files = write_pictures(tmp_path / "data", 2)
    before = open_pictures(files, 32, tmp_path / "kept").pixels.copy()
    (tmp_path / "kept" / "pictures.json").unlink()
    (tmp_path / "kept" / "pixels.u8").write_bytes(b"half")
    assert (open_pictures(files, 32, tmp_path / "kept").pixels == before).all()


@pytest.mark.parametrize("window", [64, 128])
def test_a_view_keeps_picture_and_identity_together(window: int) -> None:
    """The thing is the only red one; wherever it goes, its identity goes too."""
    pixels = np.full((128, 128, 3), 80, dtype=np.uint8)
    owners = np.zeros((128, 128), dtype=np.uint8)
    owners[20:50, 70:110] = 7
    pixels[owners == 7] = (230, 80, 80)
    rng = np.random.default_rng(0)
    shown = []
    for _ in range(40):
        view = draw_view(128, window, 16, (90.0, 35.0), rng)
        colours, moved = look(view, pixels, owners)
        assert colours.shape == (window, window, 3)
        assert (((colours[..., 0] > 155) == (moved == 7)).mean()) > 0.98
        last = (128 - window) // 16
        assert 0 <= min(view.corner) <= max(view.corner) <= last
        shown.append(bool((moved == 7).any()))
    assert np.mean(shown) > 0.9


def test_light_changes_and_hues_stay() -> None:
    pixels = torch.full((16, 3, 32, 32), 0.2)
    pixels[:, 0] = 0.7
    changed = relight(pixels, torch.Generator().manual_seed(0))
    assert 0.0 <= float(changed.min()) <= float(changed.max()) <= 1.0
    means = changed.mean(dim=(2, 3))
    assert bool((means[:, 0] > 1.5 * means[:, 1:].max(dim=1).values).all())
    assert float(means[:, 0].std()) > 0.03


def test_what_is_cut_off_is_not_in_the_picture_and_takes_no_part_in_large_and_small() -> None:
    part = cropped(TOOLS, 320, 360, {1: 4000, 2: 0, 3: 10})
    assert [(item.id, item.visible_pixels) for item in part.objects] == [(1, 4000), (3, 10)]
    assert "wooden brush" in part.objects[0].phrases
    assert not [text for text in part.objects[0].phrases if text.startswith("large")]
    whole = cropped(TOOLS, 640, 360, {1: 1, 2: 1, 3: 1})
    assert "large brush" in whole.objects[0].phrases


def test_a_directory_without_pictures_says_how_to_make_some(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="w2c scenes render"):
        truth_files(tmp_path)
    with pytest.raises(ConfigError, match="no directory"):
        truth_files(tmp_path / "none")


def test_damaged_files_are_named(tmp_path: Path) -> None:
    (file,) = write_pictures(tmp_path, 1)
    (tmp_path / "0000000_identity.png").write_bytes(b"")
    with pytest.raises(ConfigError, match="identity"):
        open_pictures([file], 32, tmp_path / "kept")
    (tmp_path / "0000000.jpg").write_bytes(b"no")
    with pytest.raises(ConfigError, match=file.name):
        open_pictures([file], 32, tmp_path / "kept")
    file.write_text("{}")
    with pytest.raises(ConfigError, match=file.name):
        read_truth(file)


def test_a_phrase_fits_every_object_it_names() -> None:
    assert fitting(TABLE, "cup") == (2, 3)
    assert fitting(TABLE, "blue mug") == (2,)
    assert fitting(TABLE, "bowl") == ()


@pytest.mark.parametrize("phrase", ["cup", "green mug", "box", "turquoise cup", "orange book"])
def test_what_somebody_could_say_is_no_negative_example(phrase: str) -> None:
    """A cereal box is a box, and borders between neighbouring colours differ between people."""
    assert could_fit(TABLE, phrase)


@pytest.mark.parametrize("phrase", ["bowl", "white book", "red cup", "blue box", "elephant"])
def test_what_nobody_would_say_is(phrase: str) -> None:
    assert not could_fit(TABLE, phrase)


@pytest.mark.parametrize(
    ("phrase", "kind"),
    [
        ("brush", "name"),
        ("hair brush", "synonym"),
        ("red hair brush", "colour"),
        ("wooden brush", "material"),
        ("red wooden brush", "material"),
        ("large red brush", "size"),
        ("thing with the wooden handle", "part"),
    ],
)
def test_phrases_name_things_in_different_ways(phrase: str, kind: str) -> None:
    assert kind_of(TOOLS.objects[0], phrase) == kind


def test_two_of_a_kind_are_told_apart_and_any_thing_by_what_it_is_like() -> None:
    offers = phrases_by_kind(TOOLS, TOOLS.objects[0])
    assert {"red brush", "wooden brush", "large brush"} <= set(offers["pair"])
    assert "brush" not in offers["pair"]
    assert set(offers["any"]) == {"red thing", "wood thing", "wooden thing"}
    assert "pair" not in phrases_by_kind(TOOLS, TOOLS.objects[2])
    # Beside an orange thing nobody agrees which one the red thing is.
    apples = scene(thing(1, "apple", "red", "apple"), thing(2, "apple", "orange", "apple"))
    assert "any" not in phrases_by_kind(apples, apples.objects[0])
    assert fitting(TOOLS, "wooden object") == (1,)
    assert fitting(TOOLS, "blue thing") == (2,)


@pytest.mark.parametrize(
    ("phrase", "fits"),
    [
        ("wooden brush", True),
        ("metal brush", False),
        ("metal cup", True),  # nobody said what it is made of
        ("thing with the wooden handle", True),
        ("thing with the metal handle", True),  # perhaps the cup's
        ("thing with the metal bristles", True),
        ("thing with the metal lid", False),
        ("metal thing", True),
        ("green thing", False),
    ],
)
def test_materials_and_parts_are_no_negative_examples_where_in_doubt(
    phrase: str, fits: bool
) -> None:
    assert could_fit(TOOLS, phrase) is fits


@pytest.mark.parametrize("truth", [TABLE, TOOLS])
def test_questions_fit_what_they_claim(truth: PictureTruth) -> None:
    asker = Asker([TABLE, TOOLS])
    rng = np.random.default_rng(0)
    clear = truth.clearly_visible()
    for _ in range(150):
        questions = asker.ask(truth, clear, 3, 2, rng)
        assert len(questions) == 5
        for question in questions[:3]:
            assert set(question.identities) & {item.id for item in clear}
        for question in questions[3:]:
            assert question.identities == ()
            assert not any(question.phrase in item.phrases for item in truth.objects)


def test_things_are_asked_for_again_where_there_are_few() -> None:
    questions = Asker([TABLE]).ask(TABLE, TABLE.objects[:1], 3, 0, np.random.default_rng(0))
    assert all(1 in question.identities for question in questions)
    assert len(questions) == 3


def test_an_empty_picture_is_asked_only_for_what_is_absent() -> None:
    questions = Asker([TABLE]).ask(scene(), [], 3, 1, np.random.default_rng(0))
    assert [question.identities for question in questions] == [()] * 4


def test_uses_fit_kinds_and_are_no_negative_examples_of_what_may_be_meant() -> None:
    lone = scene(thing(1, "mug", "red", "cup"), thing(2, "hammer", "blue", "hammer"))
    drink, hit = "thing to drink from", "thing to hit nails with"
    assert drink in phrases_by_kind(lone, lone.objects[0])["use"]
    assert fitting(lone, drink) == (1,)
    assert fitting(lone, hit) == (2,)
    # One may drink from a bottle, but nobody is asked for it in these words.
    doubtful = scene(thing(1, "mug", "red", "cup"), thing(2, "bottle", "green", "bottle"))
    assert drink not in phrases_by_kind(doubtful, doubtful.objects[0]).get("use", ())
    assert could_fit(scene(doubtful.objects[1]), drink)
    assert not could_fit(scene(lone.objects[1]), drink)


def test_the_vocabulary_names_things_and_nothing_foreign() -> None:
    assert "dog" in {word for use in EVERY_USE for word in words(use)}
    ball = vocabulary_of([scene(thing(1, "ball", "red", "ball"))])
    assert {"ball", "play"} <= set(ball)
    assert "dog" not in ball
    vocabulary = vocabulary_of([TABLE])
    assert {"book", "cup", "cereal", "red"} <= set(vocabulary)
    assert not set(vocabulary) & {word for noun in FOREIGN for word in words(noun)}
    assert {"the", *vocabulary} <= set(tokenizer_words(vocabulary))


def test_invented_words_are_words() -> None:
    rng = np.random.default_rng(0)
    assert all(words(invented_word(rng)) for _ in range(50))


def test_of_two_of_a_kind_one_is_asked_for_by_material_as_often_as_by_colour(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    only_pairs = {kind: float(kind == "pair") for kind in asker.SHARES}
    monkeypatch.setattr(asker, "SHARES", only_pairs)
    cups = [
        ObjectTruth(
            number, "mug", colour, ("mug", "cup", "beaker"),
            ("mug", "cup", "beaker", f"{colour} mug", f"{colour} cup", f"{colour} beaker",
             f"{material} mug"),
            5000, material,
        )
        for number, colour, material in ((1, "red", "metal"), (2, "blue", "ceramic"))
    ]  # fmt: skip
    truth = PictureTruth("0.jpg", "0.png", 320, 180, 0, tuple(cups))
    questions = Asker([truth]).ask(truth, cups, 400, 0, np.random.default_rng(3))
    of_material = sum("metal" in q.phrase or "ceramic" in q.phrase for q in questions)

    assert 160 < of_material < 240
    assert all(len(question.identities) == 1 for question in questions)


def test_one_of_two_of_a_kind_is_asked_for_more_often(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(asker, "SHARES", {kind: float(kind == "name") for kind in asker.SHARES})
    items = [thing(1, "mug", "red", "mug"), thing(2, "mug", "blue", "mug")]
    items += [thing(number, f"kind{number}", "red", f"name{number}") for number in range(3, 9)]
    truth = PictureTruth("0.jpg", "0.png", 320, 180, 0, tuple(items))
    source = Asker([truth])
    rng = np.random.default_rng(3)
    asked = [source.ask(truth, items, 1, 0, rng)[0] for _ in range(600)]
    of_the_pair = sum("mug" in question.phrase for question in asked)

    assert 200 < of_the_pair < 280  # 240 of twice the weight, 150 of the same
