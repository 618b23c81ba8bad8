"""Regions that a phrase lights are looked at again: what is cut out, and what it changes."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from w2c.errors import ModelError
from w2c_grounding.beside import carried
from w2c_grounding.evidence import find, peak_point, regions_of
from w2c_grounding.family import Evidence, Heatmap, RgbImage, ScoredBox
from w2c_grounding.folding import folded
from w2c_grounding.second_look import weights
from w2c_grounding.second_look.crops import (
    GREY,
    PICTURE_WIDTH,
    SIDE,
    brought_to_width,
    square_around,
)
from w2c_grounding.second_look.looks_again import LooksAgain
from w2c_grounding.second_look.network import WIDTH, SecondLookNetwork, said, with_words
from w2c_grounding.second_look.regions import FAINTEST, worth_a_look
from w2c_grounding.second_look.weighing import weighed
from w2c_grounding.things.proposals import Thing

EDGE = 0.3
WORDS = ("red", "blue", "mug", "box")


def picture(*things: tuple[int, int, int, tuple[int, int, int]]) -> RgbImage:
    """Return a black picture with coloured squares: left, top, side, colour."""
    image = np.zeros((240, 320, 3), np.uint8)
    for left, top, side, colour in things:
        image[top : top + side, left : left + side] = colour
    return image


RED, BLUE = (220, 20, 20), (20, 20, 220)


def heat(*squares: tuple[int, int, int, float]) -> Heatmap:
    """Return heat in squares: left, top, side, and how hot."""
    result = np.full((240, 320), 0.01, np.float32)
    for left, top, side, hot in squares:
        result[top : top + side, left : left + side] = hot
    return result


class LightsBoth:
    """A family to which a red and a blue mug are the same, the blue one a little hotter."""

    def __init__(self, boxes: tuple[ScoredBox, ...] | None = None) -> None:
        self._boxes = boxes

    def prepare(self, image: RgbImage) -> None:
        """Keep nothing."""

    def query(self, context: None, phrases: Sequence[str]) -> list[Evidence]:
        """Return the same heat for any phrase."""
        both = heat((40, 60, 50, 0.7), (200, 60, 50, 0.8))
        return [Evidence(both, self._boxes) for _ in phrases]


class KnowsRed(SecondLookNetwork):
    """A second look that sees which of red and blue there is more of."""

    def see(self, squares: torch.Tensor) -> torch.Tensor:
        """Return how much redder than blue squares are, in every dimension."""
        redder = (squares[:, 0] - squares[:, 2]).mean(dim=(1, 2))
        return redder[:, None].expand(-1, WIDTH)

    def read(self, tokens: torch.Tensor, lengths: torch.Tensor) -> torch.Tensor:
        """Return 1 for phrases with red, -1 for those with blue, else 0."""
        red = (tokens == self.numbers["red"]).any(dim=1).float()
        blue = (tokens == self.numbers["blue"]).any(dim=1).float()
        return (red - blue)[:, None].expand(-1, WIDTH)

    def match(self, seen: torch.Tensor, meant: torch.Tensor) -> torch.Tensor:
        """Return a logit that is high where both agree."""
        return 20.0 * (seen * meant).mean(dim=-1)


MUGS = picture((40, 60, 50, RED), (200, 60, 50, BLUE))


def asked(phrases: Sequence[str], family: LightsBoth | None = None) -> list[Heatmap]:
    looks = LooksAgain(family or LightsBoth(), KnowsRed(WORDS), edge=EDGE)
    return [one.heatmap for one in looks.query(looks.prepare(MUGS), phrases)]


def test_what_the_second_look_knows_decides_between_two_that_are_lit() -> None:
    red, blue = asked(["the red mug", "blue mug"])
    assert peak_point(red)[0] < 100
    assert peak_point(blue)[0] > 190
    # What is said of one of them loses its heat on the other.
    assert float(red[60:110, 200:250].max()) < 0.3
    assert float(red[60:110, 40:90].max()) > 0.7


def test_a_phrase_that_fits_both_leaves_both() -> None:
    (both,) = asked(["mug"])
    assert len(find(both, 0.5, edge=EDGE).regions) == 2
    assert np.allclose(both, heat((40, 60, 50, 0.7), (200, 60, 50, 0.8)), atol=1e-3)


@pytest.mark.parametrize("phrase", ["red teapot", "the", "teapot"])
def test_a_word_that_it_does_not_know_leaves_the_heat_alone(phrase: str) -> None:
    assert np.array_equal(asked([phrase])[0], heat((40, 60, 50, 0.7), (200, 60, 50, 0.8)))


def test_a_family_with_boxes_of_its_own_is_left_alone() -> None:
    boxes = (ScoredBox(200.0, 60.0, 250.0, 110.0, 0.8),)
    assert peak_point(asked(["red mug"], LightsBoth(boxes))[0])[0] > 190


def test_it_is_asked_about_squares_of_the_picture_at_the_width_of_its_training() -> None:
    shapes: list[tuple[int, ...]] = []

    class Notes(KnowsRed):
        def see(self, squares: torch.Tensor) -> torch.Tensor:
            shapes.append(tuple(squares.shape))
            return super().see(squares)

    looks = LooksAgain(LightsBoth(), Notes(WORDS), edge=EDGE)
    context = looks.prepare(MUGS)
    looks.query(context, ["red mug"])
    assert context.image.shape[1] == PICTURE_WIDTH
    assert shapes == [(2, 3, SIDE, SIDE)]


def seen_at(left: int, top: int, side: int) -> Thing:
    """Return a square thing of the picture, seen all over it, in fields of 10 px."""
    places = np.zeros((24, 32), np.bool_)
    places[top // 10 : (top + side) // 10, left // 10 : (left + side) // 10] = True
    box = (left / 320, top / 240, (left + side) / 320, (top + side) / 240)
    return Thing(box, places, 0.9)


BOTH_THINGS = (seen_at(40, 60, 50), seen_at(200, 60, 50))


class LightsNothing(LightsBoth):
    """A family that misses everything."""

    def query(self, context: None, phrases: Sequence[str]) -> list[Evidence]:
        """Return the same faint heat for any phrase."""
        return [Evidence(heat()) for _ in phrases]


class CountsLooks(KnowsRed):
    """Notes how many squares it is shown at a time."""

    def __init__(self) -> None:
        super().__init__(WORDS)
        self.shown: list[int] = []

    def see(self, squares: torch.Tensor) -> torch.Tensor:
        """Return what it sees."""
        self.shown.append(len(squares))
        return super().see(squares)


def asked_of_things(
    phrases: Sequence[str],
    family: LightsBoth,
    things: Sequence[Thing] = BOTH_THINGS,
    network: KnowsRed | None = None,
) -> list[Heatmap]:
    looks = LooksAgain(
        family, network or KnowsRed(WORDS), edge=EDGE, find_things=lambda context: things
    )
    return [one.heatmap for one in looks.query(looks.prepare(MUGS), phrases)]


def test_a_thing_that_the_family_misses_is_found_by_its_looks() -> None:
    red, blue, teapot = asked_of_things(["red mug", "blue mug", "red teapot"], LightsNothing())
    (there,) = find(red, 0.5, edge=EDGE).regions
    assert (there.left, there.top, there.right, there.bottom) == (40, 60, 90, 110)
    assert peak_point(blue)[0] > 190
    assert np.array_equal(teapot, heat()), "a word that it does not know"
    assert np.array_equal(asked(["red mug"], LightsNothing())[0], heat()), "without things"


def test_things_are_looked_at_once_for_all_phrases() -> None:
    network = CountsLooks()
    asked_of_things(["red mug", "blue mug", "mug"] * 5, LightsBoth(), network=network)
    assert network.shown == [2]


def test_what_is_lit_beside_things_is_looked_at_as_well() -> None:
    network = CountsLooks()
    (blue,) = asked_of_things(["blue mug"], LightsBoth(), BOTH_THINGS[:1], network)
    assert network.shown == [1, 1]
    assert peak_point(blue)[0] > 190


def test_a_picture_without_things_is_asked_about_as_ever() -> None:
    (found,) = asked_of_things(["blue mug"], LightsBoth(), ())
    assert np.array_equal(found, asked(["blue mug"])[0])


def test_a_family_with_boxes_of_its_own_is_left_alone_where_things_are_known() -> None:
    boxes = (ScoredBox(200.0, 60.0, 250.0, 110.0, 0.8),)
    family = LightsBoth(boxes)
    (found,) = asked_of_things(["red mug"], family)
    assert np.array_equal(found, family.query(None, ["red mug"])[0].heatmap)


def test_many_phrases_with_and_without_regions_keep_their_order() -> None:
    phrases = ["red mug", "teapot", "blue mug", "red mug"] * 20
    for answered in (asked(phrases), asked_of_things(phrases, LightsBoth())):
        answers = [peak_point(one)[0] < 100 for one in answered]
        assert answers == [True, False, False, True] * 20


def test_what_is_faint_beside_a_sure_region_is_looked_at_too() -> None:
    uneven = heat((40, 60, 50, 0.08), (200, 60, 50, 0.9))
    found = worth_a_look(uneven, EDGE)
    assert [(one.left, one.right, round(one.score, 2)) for one in found] == [
        (200, 250, 0.9),
        (40, 90, 0.08),
    ]
    assert all(one.mask.all() and one.mask.shape == (50, 50) for one in found)

    class SureOfOne(LightsBoth):
        def query(self, context: None, phrases: Sequence[str]) -> list[Evidence]:
            return [Evidence(uneven) for _ in phrases]

    red, blue = asked(["red mug", "blue mug"], SureOfOne())
    assert peak_point(red)[0] < 100
    assert peak_point(blue)[0] > 190


@given(
    st.lists(
        st.tuples(st.integers(0, 9), st.integers(9, 60), st.floats(0.3, 1.0)),
        min_size=1,
        max_size=4,
    ),
    st.integers(0, 170),
)
def test_clear_regions_are_those_of_the_heatmap(
    squares: list[tuple[int, int, float]], top: int
) -> None:
    level = heat(
        *((70 * n + right, top + right, side, hot) for n, (right, side, hot) in enumerate(squares))
    )
    expected = regions_of(level, FAINTEST, EDGE)
    found = worth_a_look(level, EDGE)[: len(expected)]
    assert {(one.left, one.top, one.right, one.bottom) for one in found} == {
        (one.left, one.top, one.right, one.bottom) for one in expected
    }
    assert all(one.mask.all() for one in found)


def test_what_is_too_faint_too_small_or_hangs_together_is_not_looked_at_apart() -> None:
    assert len(worth_a_look(heat((40, 60, 50, 0.04), (200, 60, 50, 0.9)), EDGE)) == 1
    assert len(worth_a_look(heat((40, 60, 4, 0.2), (200, 60, 50, 0.9)), EDGE)) == 1
    assert len(worth_a_look(heat((150, 60, 50, 0.2), (200, 60, 50, 0.9)), EDGE)) == 1
    many = heat((200, 160, 50, 0.9), *((5 + 30 * n, 20, 20, 0.1 + 0.01 * n) for n in range(10)))
    found = worth_a_look(many, EDGE)
    assert len(found) == 8
    assert [one.score for one in found] == sorted((one.score for one in found), reverse=True)


def test_a_speck_is_looked_at_where_it_is_the_hottest_alone() -> None:
    assert [one.left for one in worth_a_look(heat((40, 60, 3, 0.8), (200, 60, 50, 0.9)), EDGE)] == [
        200
    ]
    assert [one.left for one in worth_a_look(heat((40, 60, 3, 0.9), (200, 60, 50, 0.8)), EDGE)] == [
        40,
        200,
    ]
    # A piece may be larger than a speck and hold nothing but specks.
    dusty = heat((40, 160, 40, 0.1), (44, 164, 3, 0.8), (60, 172, 3, 0.7), (200, 60, 50, 0.9))
    assert [one.left for one in worth_a_look(dusty, EDGE)] == [200]


def test_nothing_lit_is_nothing_to_look_at() -> None:
    class Dark(LightsBoth):
        def query(self, context: None, phrases: Sequence[str]) -> list[Evidence]:
            return [Evidence(heat()) for _ in phrases]

    assert np.array_equal(asked(["red mug"], Dark())[0], heat())


@given(
    st.lists(st.floats(0.125, 1.0, width=32), min_size=1, max_size=4),
    st.lists(st.floats(-60.0, 60.0, width=32), min_size=4, max_size=4),
)
def test_scores_are_probabilities_and_all_else_stays_below_the_surest(
    heats: list[float], logits: list[float]
) -> None:
    before = heat(*((10 + 70 * n, 20, 40, hot) for n, hot in enumerate(heats)))
    regions = regions_of(before, FAINTEST, EDGE)
    after = weighed(before, regions, logits[: len(regions)], EDGE)
    assert after.dtype == np.float32
    assert np.isfinite(after).all()
    assert 0.0 <= float(after.min()) <= float(after.max()) < 1.0
    inside = np.zeros(after.shape, bool)
    for one in regions:
        inside[one.top : one.bottom, one.left : one.right] |= one.mask
    highest = float(after[inside].max())
    assert highest == float(after.max())
    assert float(after[~inside].max()) < EDGE * highest


def test_a_square_holds_the_whole_box_in_its_middle_and_grey_beyond_the_picture() -> None:
    image = picture((100, 80, 40, RED))
    square = square_around(image, (100, 80, 140, 120))
    assert square.shape == (SIDE, SIDE, 3)
    red = np.argwhere(square[..., 0] > 110)
    assert np.allclose(red.mean(axis=0), (SIDE - 1) / 2, atol=1.5)
    assert np.allclose(np.ptp(red, axis=0) + 1, SIDE / 1.15, atol=3)
    corner = square_around(image, (0, 0, 40, 40), margin=1.0)
    assert tuple(corner[0, 0]) == GREY
    assert tuple(corner[-1, -1]) == (0, 0, 0)


@given(
    left=st.floats(0, 319),
    top=st.floats(0, 239),
    width=st.floats(0.5, 320),
    height=st.floats(0.5, 240),
)
def test_any_box_of_a_picture_makes_a_square(
    left: float, top: float, width: float, height: float
) -> None:
    box = (left, top, min(left + width, 320), min(top + height, 240))
    assert square_around(MUGS, box).shape == (SIDE, SIDE, 3)


def test_a_picture_is_brought_to_the_width_of_the_training() -> None:
    small, scale = brought_to_width(np.zeros((1080, 1920, 3), np.uint8))
    assert small.shape == (720, 1280, 3)
    assert scale == pytest.approx(2.0 / 3.0)


def test_norms_are_folded_into_convolutions_and_the_answers_stay() -> None:
    torch.manual_seed(3)
    network = SecondLookNetwork(WORDS)
    squares = torch.rand(6, 3, SIDE, SIDE)
    for _ in range(3):
        network.see(squares)  # means and variances that no norm begins with
    network.eval()
    with torch.inference_mode():
        expected = network.see(squares)
        short = folded(network)
        assert torch.allclose(short.see(squares), expected, atol=1e-4)
        assert torch.equal(network.see(squares), expected)
    assert not any(isinstance(one, torch.nn.BatchNorm2d) for one in short.modules())


def test_words_that_only_introduce_are_not_read() -> None:
    assert said("The red mug") == ["red", "mug"]
    network = SecondLookNetwork(WORDS).eval()
    with torch.inference_mode():
        bare, framed, turned = network.read(*network.tokens(["red mug", "my red mug", "mug red"]))
    assert torch.allclose(bare, framed, atol=1e-6)
    assert not torch.allclose(bare, turned, atol=1e-3)


def test_phrases_of_other_lengths_do_not_change_what_one_means() -> None:
    network = SecondLookNetwork(WORDS).eval()
    with torch.inference_mode():
        alone = network.read(*network.tokens(["red mug"]))
        beside = network.read(*network.tokens(["red mug", "red blue box mug box", "teapot"]))
    assert torch.allclose(alone[0], beside[0], atol=1e-6)


def test_known_words_mean_what_they_meant_where_others_are_added() -> None:
    network = SecondLookNetwork(WORDS).eval()
    grown = with_words(network, ["mug", "teapot", "apron"]).eval()
    assert grown.vocabulary == [*WORDS, "apron", "teapot"]
    with torch.inference_mode():
        for phrase in ("red mug", "box", "zebra"):
            before, after = (net.read(*net.tokens([phrase])) for net in (network, grown))
            assert torch.equal(before, after)
        known, unknown = grown.read(*grown.tokens(["teapot", "zebra"]))
    assert not torch.allclose(known, unknown, atol=1e-3)


def test_a_network_is_read_as_it_was_written(tmp_path: Path) -> None:
    network = SecondLookNetwork(WORDS).eval()
    weights.write(network, tmp_path)
    again = weights.read(tmp_path)
    assert again.vocabulary == list(WORDS)
    squares = torch.rand(2, 3, SIDE, SIDE)
    with torch.inference_mode():
        one, other = (
            net.match(net.see(squares), net.read(*net.tokens(["red mug", "box"])))
            for net in (network, again)
        )
    assert torch.allclose(one, other, atol=1e-2)


@pytest.mark.parametrize("content", [None, b"", b"no weights at all", b"\xff" * 400])
def test_a_file_that_is_none_is_refused_with_what_to_do(
    content: bytes | None, tmp_path: Path
) -> None:
    if content is not None:
        (tmp_path / weights.FILE).write_bytes(content)
    with pytest.raises(ModelError, match="w2c train second-look"):
        weights.read(tmp_path)


def test_a_file_of_other_weights_is_refused(tmp_path: Path) -> None:
    from safetensors.torch import save_file

    save_file({"weight": torch.zeros(3)}, tmp_path / weights.FILE, metadata={"vocabulary": "[]"})
    with pytest.raises(ModelError, match="copy the whole checkpoint directory"):
        weights.read(tmp_path)


def test_what_a_checkpoint_has_not_is_not_carried(tmp_path: Path) -> None:
    assert not carried(None, tmp_path / "new", weights.FILE)
    assert not carried(tmp_path, tmp_path / "new", weights.FILE)
    weights.write(SecondLookNetwork(WORDS), tmp_path)
    assert carried(tmp_path, tmp_path / "new", weights.FILE)
    assert weights.read(tmp_path / "new").vocabulary == list(WORDS)
