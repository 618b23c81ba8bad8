"""Words of phrases."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c.errors import ConfigError, RefusedError
from w2c_grounding.wording import (
    check_template,
    fill,
    normalised,
    spelt_as_known,
    unknown_words,
    words,
)


def test_a_phrase_is_read_in_lower_case_without_punctuation() -> None:
    assert normalised("  The RED cup!! ") == "the red cup"


def test_words_keep_apostrophes_and_hyphens_inside() -> None:
    assert words("the robot's well-worn cup_2") == ["the", "robot's", "well-worn", "cup", "2"]


@pytest.mark.parametrize(
    ("phrase", "found"),
    [
        ("3.5 inch disk.", ["3", "5", "inch", "disk"]),
        ("la cafetera, ñandú", ["la", "cafetera", "ñandú"]),
        ("cafe\u0301s", ["caf\u00e9s"]),
        ("लाल किताब", ["लाल", "किताब"]),
        ("หนังสือ", ["หนังสือ"]),
        ("كتب", ["كتب"]),
        ("\u0645\u06cc\u200c\u0631\u0648\u0645", ["\u0645\u06cc\u200c\u0631\u0648\u0645"]),
        ("红色的杯子", ["红色的杯子"]),
    ],
)
def test_words_of_any_script_stay_whole(phrase: str, found: list[str]) -> None:
    assert words(phrase) == found


@pytest.mark.parametrize("phrase", ["", "  ", "?!", "...", "📦\ufe0f", "\u0301"])
def test_a_phrase_without_a_word_is_refused(phrase: str) -> None:
    with pytest.raises(RefusedError, match="holds no word"):
        normalised(phrase)


@given(st.text())
def test_normalising_twice_is_normalising_once(text: str) -> None:
    if words(text):
        assert normalised(normalised(text)) == normalised(text)


def test_unknown_words_come_in_their_order_once_each() -> None:
    assert unknown_words("the flurb book on a flurb zog", ["book"]) == ["flurb", "zog"]


def test_without_a_vocabulary_no_word_is_called_unknown() -> None:
    assert unknown_words("flurb", None) == []


KNOWN = ["emails", "cereal", "box", "mug", "grey", "washing-up", "glass"]


@pytest.mark.parametrize(
    ("phrase", "spelt"),
    [
        ("e-mails", "emails"),
        ("email", "email"),
        ("gray cereal-box", "grey cereal box"),
        ("mugs", "mug"),
        ("boxes on the washing-up", "box on the washing-up"),
        ("grey glass", "grey glass"),
        ("flurbs of a cereal-flurb", "flurbs of a cereal-flurb"),
        ("s es", "s es"),
    ],
)
def test_a_word_in_another_spelling_is_known(phrase: str, spelt: str) -> None:
    assert spelt_as_known(phrase, KNOWN) == spelt
    assert spelt_as_known(phrase, None) == phrase


@given(st.text(alphabet="abegmrsuxy-' ").filter(words))
def test_another_spelling_makes_words_known_and_none_unknown(text: str) -> None:
    phrase = normalised(text)
    spelt = spelt_as_known(phrase, KNOWN)
    assert spelt_as_known(spelt, KNOWN) == spelt
    assert set(unknown_words(spelt, KNOWN)) <= set(unknown_words(phrase, KNOWN))


def test_a_template_has_one_place_for_the_phrase() -> None:
    assert fill(check_template("a photo of a {}"), "cup") == "a photo of a cup"
    for wrong in ("a photo", "{} and {}"):
        with pytest.raises(ConfigError, match="exactly one"):
            check_template(wrong)


def test_a_template_that_has_an_article_takes_the_phrase_without_its_own() -> None:
    assert fill("a photo of a {}", "the red cup") == "a photo of a red cup"
    assert fill("a photo of {}", "the red cup") == "a photo of the red cup"
    assert fill("a photo of a {}", "theatre") == "a photo of a theatre"
