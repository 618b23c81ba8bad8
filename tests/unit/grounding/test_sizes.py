"""Large and small are told by comparing what the rest of a phrase fits."""

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c_grounding.evidence import find, peak_point
from w2c_grounding.family import Evidence, Heatmap, RgbImage, ScoredBox
from w2c_grounding.sizes import LARGE, SIZE_WORDS, SMALL, ComparesSizes, Sized, compared, split

SIDE = 200
THRESHOLD = 0.5


def heat(*squares: tuple[int, int, int, float]) -> Heatmap:
    """Return heat in squares: left, top, side, and how hot."""
    result = np.zeros((SIDE, SIDE), dtype=np.float32)
    for left, top, side, hot in squares:
        result[top : top + side, left : left + side] = hot
    return result


SMALLER = (10, 10, 20, 0.95)
LARGER = (100, 100, 60, 0.85)


@pytest.mark.parametrize(
    ("phrase", "rest", "large"),
    [
        ("small mug", "mug", False),
        ("the larger red mug", "the red mug", True),
        ("red tiny mug", "red mug", False),
        ("biggest box of nails", "box of nails", True),
    ],
)
def test_a_word_of_size_is_taken_out(phrase: str, rest: str, large: bool) -> None:
    assert split(phrase) == Sized(rest, large)


@pytest.mark.parametrize(
    "phrase", ["mug", "small", "the small one", "small thing", "mug small", "big small mug", "big"]
)
def test_what_compares_nothing_is_left_alone(phrase: str) -> None:
    assert split(phrase) is None


@given(st.lists(st.sampled_from([*sorted(SIZE_WORDS), "the", "red", "mug", "one"]), min_size=1))
def test_what_is_asked_for_instead_says_no_size(words: list[str]) -> None:
    sized = split(" ".join(words))
    if sized is not None:
        assert not SIZE_WORDS.intersection(sized.rest.split())
        assert sized.rest.split() == [word for word in words if word not in SIZE_WORDS]


@pytest.mark.parametrize(
    ("phrase", "sized"),
    [
        pytest.param("small shovel", None, id="the name alone"),
        pytest.param("the wooden small shovel", None, id="of something"),
        pytest.param("small small shovel", Sized("small shovel", False), id="a size before it"),
        pytest.param("big small shovel", Sized("small shovel", True), id="another one"),
        pytest.param("small wooden shovel", Sized("wooden shovel", False), id="not the name"),
        pytest.param("small mug", Sized("mug", False), id="another thing"),
    ],
)
def test_a_word_of_size_in_a_name_is_none(phrase: str, sized: Sized | None) -> None:
    assert split(phrase, ["small shovel"]) == sized


def test_no_word_is_large_and_small() -> None:
    assert not SMALL & LARGE


@pytest.mark.parametrize(("large", "chosen"), [(True, LARGER), (False, SMALLER)])
def test_one_of_two_remains(large: bool, chosen: tuple[int, int, int, float]) -> None:
    evidence = compared(Evidence(heat(SMALLER, LARGER)), THRESHOLD, large=large)

    finding = find(evidence.heatmap, THRESHOLD)
    left, top, side, hot = chosen
    (region,) = finding.regions
    assert (region.left, region.top, region.right, region.bottom) == (
        left, top, left + side, top + side,
    )  # fmt: skip
    assert finding.score == pytest.approx(hot)
    u, v = peak_point(evidence.heatmap)
    assert left <= u <= left + side
    assert top <= v <= top + side


def test_the_others_stay_below_a_lower_edge() -> None:
    evidence = compared(Evidence(heat(SMALLER, LARGER)), THRESHOLD, large=True, edge=0.3)
    (region,) = find(evidence.heatmap, THRESHOLD, edge=0.3).regions
    assert (region.left, region.top) == LARGER[:2]


@pytest.mark.parametrize(("large", "index"), [(True, 1), (False, 0)])
def test_of_a_detectors_boxes_one_remains(large: bool, index: int) -> None:
    boxes = tuple(
        ScoredBox(left, top, left + side, top + side, hot)
        for left, top, side, hot in (SMALLER, LARGER)
    )
    evidence = compared(Evidence(heat(SMALLER, LARGER), boxes), THRESHOLD, large=large)
    assert evidence.boxes is not None
    assert list(evidence.boxes) == [pytest.approx(boxes[index])]


@pytest.mark.parametrize(
    "squares",
    [
        pytest.param((SMALLER,), id="one thing"),
        pytest.param((), id="nothing"),
        pytest.param(((2, 100, 99, 0.9), (101, 100, 99, 0.9)), id="two alike"),
        pytest.param((LARGER, (10, 10, 20, 0.3)), id="the other far below the threshold"),
        pytest.param(((100, 100, 60, 0.99), (10, 10, 20, 0.7)), id="the other less sure"),
        pytest.param(((10, 10, 40, 0.4), (100, 100, 60, 0.4)), id="none that fits"),
        pytest.param(((10, 10, 40, 0.9), (100, 100, 4, 0.9)), id="a stain"),
        pytest.param(((10, 10, 90, 0.9), (120, 120, 12, 0.9)), id="a piece"),
    ],
)
def test_where_sizes_tell_nothing_all_stays(squares: tuple[tuple[int, int, int, float]]) -> None:
    evidence = Evidence(heat(*squares))
    assert compared(evidence, THRESHOLD, large=False) is evidence


@pytest.mark.parametrize("threshold", [0.5, 0.507, 0.51, 0.53])
def test_beside_one_that_fits_another_may_be_less_sure(threshold: float) -> None:
    large = (100, 100, 60, 0.55)
    evidence = compared(Evidence(heat(large, (10, 10, 20, 0.48))), threshold, large=False)
    (region,) = find(evidence.heatmap, threshold).regions
    assert (region.left, region.top) == (10, 10)


def test_so_may_a_detectors_box() -> None:
    squares = (LARGER, (10, 10, 20, 0.4))
    boxes = tuple(ScoredBox(x, y, x + side, y + side, hot) for x, y, side, hot in squares)
    evidence = compared(Evidence(heat(*squares), boxes), THRESHOLD, large=False)
    (region,) = find(evidence.heatmap, THRESHOLD, boxes=evidence.boxes).regions
    assert (region.left, region.top) == (10, 10)


def test_of_two_of_one_area_the_lower_one_is_nearer_and_so_the_small_one() -> None:
    far, near = (10, 10, 40, 0.9), (100, 150, 40, 0.8)
    evidence = compared(Evidence(heat(far, near)), THRESHOLD, large=False)
    (region,) = find(evidence.heatmap, THRESHOLD).regions
    assert (region.left, region.top) == near[:2]


class Remembers:
    """A family that notes what it is asked."""

    def __init__(self) -> None:
        self.asked: list[str] = []

    def prepare(self, image: RgbImage) -> Heatmap:
        return heat(SMALLER, LARGER)

    def query(self, context: Heatmap, phrases: Sequence[str]) -> list[Evidence]:
        self.asked += phrases
        return [Evidence(context) for _ in phrases]


def test_a_model_is_asked_for_the_rest() -> None:
    family = Remembers()
    compares = ComparesSizes(family, THRESHOLD)
    context = compares.prepare(np.zeros((SIDE, SIDE, 3), dtype=np.uint8))
    plain, large = compares.query(context, ["mug", "large mug"])
    assert family.asked == ["mug", "mug"]
    assert len(find(plain.heatmap, THRESHOLD).regions) == 2
    assert len(find(large.heatmap, THRESHOLD).regions) == 1


def test_a_name_is_asked_for_whole() -> None:
    family = Remembers()
    compares = ComparesSizes(family, THRESHOLD, names=["big wheel"])
    compares.query(heat(SMALLER, LARGER), ["big wheel", "small big wheel"])
    assert family.asked == ["big wheel", "big wheel"]


def test_what_is_less_sure_is_not_smaller_for_that() -> None:
    sure, unsure = heat((10, 70, 40, 0.95)), heat((100, 70, 30, 0.85))
    rim = heat((90, 60, 50, 0.27))
    heatmap = np.maximum(np.maximum(sure, unsure), rim)
    chosen = compared(Evidence(heatmap), THRESHOLD, large=True, edge=0.3)
    assert peak_point(chosen.heatmap)[0] > 90


def test_where_one_is_certain_another_that_is_likely_is_not_of_its_kind() -> None:
    certain, likely = (100, 100, 60, 0.9999), (10, 10, 30, 0.85)
    beside = compared(Evidence(heat(certain, likely)), THRESHOLD, large=False)
    assert peak_point(beside.heatmap)[0] >= 100
    both = compared(Evidence(heat((100, 100, 60, 0.9), likely)), THRESHOLD, large=False)
    assert peak_point(both.heatmap)[0] < 50


def test_where_none_is_likely_all_are_compared() -> None:
    faint = heat((100, 100, 60, 0.4), (10, 10, 30, 0.38))
    small = compared(Evidence(faint), 0.3, large=False)
    assert peak_point(small.heatmap)[0] < 50


WHOLE = (100, 80, 40, 0.9)


@pytest.mark.parametrize(("side", "large", "is_cut_off"), [
    pytest.param(36, False, False, id="it may be larger than it looks"),
    pytest.param(25, False, True, id="so much larger it is not"),
    pytest.param(36, True, False, id="what shows is no larger"),
    pytest.param(50, True, True, id="what shows is larger already"),
])  # fmt: skip
def test_what_the_border_cuts_off_may_be_larger_than_it_looks(
    side: int, large: bool, is_cut_off: bool
) -> None:
    cut_off = (0, 100 - side // 2, side, 0.9)
    chosen = compared(Evidence(heat(cut_off, WHOLE)), THRESHOLD, large=large)
    assert (peak_point(chosen.heatmap)[0] < 100) == is_cut_off


def test_what_is_hidden_in_part_is_as_large_as_it_is_long() -> None:
    hidden = heat((20, 70, 60, 0.9), WHOLE)
    hidden[80:, 30:80] = 0.0
    chosen = compared(Evidence(hidden), THRESHOLD, large=True)
    assert peak_point(chosen.heatmap)[0] < 100


def test_both_may_be_cut_off() -> None:
    cut_off = (0, 50, 20, 0.9), (0, 100, 40, 0.9)
    small = compared(Evidence(heat(*cut_off)), THRESHOLD, large=False)
    assert peak_point(small.heatmap)[1] < 70


BRIDGE = (90, 100, 10, 0.6)


@pytest.mark.parametrize(("large", "left", "right"), [(True, 30, 95), (False, 95, 130)])
def test_two_that_touch_are_parted_between_them(large: bool, left: int, right: int) -> None:
    touching = heat((30, 70, 60, 0.9), BRIDGE, (100, 90, 30, 0.95))
    chosen = compared(Evidence(touching), THRESHOLD, large=large)
    (region,) = find(chosen.heatmap, THRESHOLD).regions
    assert (region.left, region.right) == (left, right)


def test_a_thing_alone_is_not_parted_into_pieces() -> None:
    speckled = Evidence(heat((30, 70, 60, 0.8), (32, 72, 4, 0.9), (80, 120, 4, 0.9)))
    assert compared(speckled, THRESHOLD, large=False) is speckled


def test_two_in_one_box_of_a_detector_stay_one() -> None:
    touching = heat((30, 70, 60, 0.9), BRIDGE, (100, 90, 30, 0.95))
    evidence = Evidence(touching, (ScoredBox(30, 70, 130, 130, 0.9),))
    assert compared(evidence, THRESHOLD, large=False) is evidence
