"""Pictures with truth, and the questions asked about them."""

from pathlib import Path

import numpy as np
import pytest

from fakes.rendered import write_pictures
from w2c.errors import ConfigError
from w2c_grounding.train.data import (
    ObjectTruth,
    PictureTruth,
    load_pictures,
    read_truth,
    truth_files,
)
from w2c_grounding.train.phrases import (
    FOREIGN,
    Asker,
    could_fit,
    fitting,
    invented_word,
    tokenizer_words,
    vocabulary_of,
)
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
    thing(5, "apple", "red", "apple", pixels=20),
)


def test_pictures_are_squashed_with_their_identities(tmp_path: Path) -> None:
    files = write_pictures(tmp_path, 3)
    assert truth_files(tmp_path) == files
    pictures = load_pictures(files, 48)
    assert pictures.pixels.shape == (3, 48, 48, 3)
    assert pictures.identities.shape == (3, 48, 48)
    for truth, pixels, owners in zip(
        pictures.truths, pictures.pixels, pictures.identities, strict=True
    ):
        assert set(np.unique(owners)) == {0, *(item.id for item in truth.objects)}
        for item in truth.objects:
            channel = ("red", "green", "blue").index(item.colour)
            assert pixels[owners == item.id].mean(axis=0).argmax() == channel


def test_a_directory_without_pictures_says_how_to_make_some(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="w2c scenes render"):
        truth_files(tmp_path)
    with pytest.raises(ConfigError, match="no directory"):
        truth_files(tmp_path / "none")


def test_damaged_files_are_named(tmp_path: Path) -> None:
    (file,) = write_pictures(tmp_path, 1)
    (tmp_path / "0000000_identity.png").write_bytes(b"")
    with pytest.raises(ConfigError, match="identity"):
        load_pictures([file], 32)
    (tmp_path / "0000000.jpg").write_bytes(b"no")
    with pytest.raises(ConfigError, match=file.name):
        load_pictures([file], 32)
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


def test_questions_fit_what_they_claim() -> None:
    asker = Asker([TABLE], frozenset({"book"}))
    rng = np.random.default_rng(0)
    for _ in range(300):
        questions = asker.ask(TABLE, 3, 2, rng)
        assert len(questions) == 5
        for question in questions[:3]:
            assert question.identities
            assert 5 not in question.identities, "it shows too little of itself"
            spoken = words(question.phrase)
            for item in TABLE.objects:
                if item.id in question.identities:
                    assert any(set(words(name)) <= set(spoken) for name in item.names)
        for question in questions[3:]:
            assert question.identities == ()


def test_an_empty_picture_is_asked_only_for_what_is_absent() -> None:
    asker = Asker([TABLE], frozenset())
    questions = asker.ask(scene(), 3, 1, np.random.default_rng(0))
    assert [question.identities for question in questions] == [()] * 4


def test_favourites_are_asked_for_more_often() -> None:
    rng = np.random.default_rng(0)

    def share(favourites: frozenset[str]) -> float:
        asker = Asker([TABLE], favourites)
        hits = [asker.ask(TABLE, 1, 0, rng)[0].identities == (1,) for _ in range(400)]
        return float(np.mean(hits))

    assert share(frozenset({"book"})) > 1.5 * share(frozenset())


def test_the_vocabulary_names_things_and_nothing_foreign() -> None:
    vocabulary = vocabulary_of([TABLE])
    assert {"book", "cup", "cereal", "red"} <= set(vocabulary)
    assert not set(vocabulary) & {word for noun in FOREIGN for word in words(noun)}
    assert {"the", *vocabulary} <= set(tokenizer_words(vocabulary))


def test_invented_words_are_words() -> None:
    rng = np.random.default_rng(0)
    assert all(words(invented_word(rng)) for _ in range(50))
