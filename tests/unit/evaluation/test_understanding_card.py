"""The card that a training writes has a place for scores, and the evaluation finds it."""

from pathlib import Path

import pytest

from w2c.errors import ConfigError
from w2c_evaluation.understanding.card import fill_card
from w2c_llm.train.card import SCORES_BEGIN, SCORES_END


def test_scores_replace_what_stood_in_their_place(tmp_path: Path) -> None:
    card = tmp_path / "README.md"
    card.write_text(f"# Card\n\n{SCORES_BEGIN}\nNot measured yet.\n{SCORES_END}\n\nLimits\n")
    fill_card(card, "| old \\1 |\n")
    fill_card(card, "| new |")
    assert card.read_text() == f"# Card\n\n{SCORES_BEGIN}\n| new |\n{SCORES_END}\n\nLimits\n"


@pytest.mark.parametrize("text", ["no place", f"{SCORES_BEGIN}\n\n{SCORES_END}\n" * 2])
def test_a_file_that_is_no_card_stays_as_it_is(text: str, tmp_path: Path) -> None:
    card = tmp_path / "README.md"
    card.write_text(text)
    with pytest.raises(ConfigError, match="places for scores"):
        fill_card(card, "| new |")
    assert card.read_text() == text
    with pytest.raises(ConfigError, match="cannot be filled"):
        fill_card(tmp_path / "missing.md", "| new |")
