"""Words as typed and as models read them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c.errors import ModelError, RefusedError
from w2c_dialogue.utterance import MAX_WORDS, Span, parse


def test_words_are_numbered_without_case_and_outer_punctuation() -> None:
    utterance = parse("  Reach for the\tNail-Box, with  your LEFT hand!! ")
    assert utterance.numbered() == "reach1 for2 the3 nail-box,4 with5 your6 left7 hand8"
    assert utterance.text == "Reach for the Nail-Box, with your LEFT hand!!"
    assert utterance.phrase(Span(4, 4)) == "Nail-Box"


def test_phrases_become_letters_that_no_word_can_be() -> None:
    utterance = parse("Between the red cup, and A big box's lid. B")
    text = utterance.with_letters([Span(3, 4), Span(7, 8)])
    assert text == "between the A, and a B's lid b"


@pytest.mark.parametrize(
    ("text", "spans", "seen"),
    [
        ("a cup or a book, nearer the book", [(2, 2), (5, 5)], "a A or a B, nearer the B"),
        ("left of the red bin, on the bin's side", [(4, 5)], "left of the A, on the A's side"),
        ("the red bin or the blue bin, the bin", [(2, 3), (6, 7)], "the A or the B, the bin"),
        ("on the mug on the left, to the left", [(3, 6)], "on the A, to the left"),
        ("on the thing to put pans on, pans on", [(3, 7)], "on the A, pans on"),
        ("by the red bin, bin it", [(3, 4)], "by the A, bin it"),
        ("the bin, left of the bin", [(6, 6)], "the bin, left of the A"),
    ],
)  # fmt: skip
def test_what_is_named_again_has_the_same_letter(
    text: str, spans: list[tuple[int, int]], seen: str
) -> None:
    assert parse(text).with_letters([Span(*span) for span in spans]) == seen


def test_a_possessive_is_no_part_of_the_phrase() -> None:
    assert parse("the book's edge").phrase(Span(2, 2)) == "book"


def test_words_are_returned_with_the_quotes_and_accents_of_the_keyboard() -> None:
    typed = "left of mum\u2019s \u201ccafe\u0301\u201d mug\u2019s handle"
    utterance = parse(typed)
    assert utterance.phrase(Span(3, 5)) == 'mum\'s "caf\u00e9" mug'
    assert utterance.verbatim(Span(3, 5)) == "mum\u2019s \u201ccafe\u0301\u201d mug"
    assert utterance.verbatim(Span(4, 4)) == "cafe\u0301"


@pytest.mark.parametrize("span", [(0, 1), (2, 1), (1, 4), (9, 9)])
def test_spans_outside_the_utterance_are_refused(span: tuple[int, int]) -> None:
    with pytest.raises(ModelError, match="not in an utterance of 3 words"):
        parse("on the book").phrase(Span(*span))


def test_too_much_is_refused_with_the_limit() -> None:
    with pytest.raises(RefusedError, match="500"):
        parse("x" * 100_000)
    with pytest.raises(RefusedError, match=str(MAX_WORDS)):
        parse("a " * (MAX_WORDS + 1))


@pytest.mark.parametrize("text", ["", "   ", "...", "\x00\x1b", "\u200b\u202e"])
def test_no_words_is_refused(text: str) -> None:
    with pytest.raises(RefusedError, match="no words"):
        parse(text)


@given(st.text(max_size=300))
def test_any_text_is_words_or_a_refusal(text: str) -> None:
    try:
        utterance = parse(text)
    except RefusedError:
        return
    assert len(utterance.typed) == len(utterance.folded) <= MAX_WORDS
    assert "\n" not in utterance.text
    assert all(word for word in utterance.folded)
    assert len(utterance.numbered().split()) == len(utterance.typed)
    for first in range(1, len(utterance.typed) + 1):
        utterance.phrase(Span(first, len(utterance.typed)))
        assert utterance.verbatim(Span(first, first)) in text
