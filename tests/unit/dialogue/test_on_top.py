"""On top of a thing is above the middle of its outline, and on it."""

import numpy as np
import pytest

from w2c.messages import Box, PhraseEvidence
from w2c_dialogue.on_top import says_on_top, upper_point
from w2c_dialogue.utterance import Mention, Span, parse

SIZE = (1280, 720)


def seen(rows: slice, columns: slice, *, heat: int = 200) -> PhraseEvidence:
    """Return a thing in a heatmap of 8 px a cell."""
    heatmap = np.zeros((90, 160), np.uint8)
    heatmap[rows, columns] = heat
    box = Box(
        left=8.0 * columns.start,
        top=8.0 * rows.start,
        right=8.0 * columns.stop,
        bottom=8.0 * rows.stop,
        score=0.9,
    )
    return PhraseEvidence(
        phrase="box", found=True, score=0.9, point=(1.0, 1.0), boxes=[box], heatmap=heatmap
    )


@pytest.mark.parametrize(
    ("text", "on_top"),
    [
        ("stand on top of the box", True),
        ("Rest your palm on the top of that box", True),
        ("atop box", True),
        ("lean on the box", False),
        ("the top of the shelf, then the box", False),
        ("stop. the box", False),
    ],
)
def test_only_the_words_before_the_name_say_so(text: str, on_top: bool) -> None:
    utterance = parse(text)
    last = len(utterance.folded)

    assert says_on_top(utterance, Mention("box", Span(last, last))) is on_top
    assert not says_on_top(utterance, Mention("box", None))


@pytest.mark.parametrize("heat", [200, 60])
def test_the_point_is_above_the_middle(heat: int) -> None:
    u, v = upper_point(seen(slice(30, 60), slice(40, 60), heat=heat), SIZE) or (0.0, 0.0)

    assert u == pytest.approx(400.0, abs=8.0)
    assert v == pytest.approx(240.0 + 0.33 * 240.0, abs=8.0)


def test_the_point_is_on_the_thing_and_not_between_its_arms() -> None:
    thing = seen(slice(30, 60), slice(40, 60))
    assert thing.heatmap is not None
    thing.heatmap[30:45, 44:56] = 0  # a gap from above

    u, v = upper_point(thing, SIZE) or (0.0, 0.0)
    assert thing.heatmap[int(v // 8), int(u // 8)] > 0
    assert v < 360.0


def test_a_cold_or_missing_heatmap_gives_no_point() -> None:
    assert upper_point(seen(slice(30, 60), slice(40, 60), heat=0), SIZE) is None
    without = PhraseEvidence(phrase="box", found=False, score=0.1, point=None, boxes=[])
    assert upper_point(without, SIZE) is None
