"""What was found is drawn from near: it ends where it ends in the picture."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from w2c.errors import ModelError
from w2c_grounding.evidence import Region, find, peak_point, regions_of
from w2c_grounding.family import Evidence, Heatmap, RgbImage, ScoredBox
from w2c_grounding.outline import weights
from w2c_grounding.outline.draws_outlines import DrawsOutlines
from w2c_grounding.outline.network import LAYERS, SIDE, OutlineNetwork
from w2c_grounding.outline.redraw import redrawn
from w2c_grounding.outline.window import LARGEST, Window, fits, layers, window_around
from w2c_grounding.second_look.crops import brought_to_width
from w2c_grounding.second_look.looks_again import LooksAgain
from w2c_grounding.second_look.network import SecondLookNetwork
from w2c_grounding.seen_near import SeenNear, seen_near

EDGE = 0.3
HEIGHT, WIDTH = 216, 384
Box = tuple[int, int, int, int]


def heat(*boxes: tuple[int, int, int, int, float]) -> Heatmap:
    """Return heat in boxes: left, top, right, bottom, and how hot."""
    result = np.full((HEIGHT, WIDTH), 0.01, np.float32)
    for left, top, right, bottom, hot in boxes:
        result[top:bottom, left:right] = hot
    return result


def picture(*boxes: Box) -> RgbImage:
    """Return a black picture with red boxes."""
    image = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    for left, top, right, bottom in boxes:
        image[top:bottom, left:right] = (230, 20, 20)
    return image


def region(left: int, top: int, right: int, bottom: int, score: float = 0.8) -> Region:
    return Region(left, top, right, bottom, score, np.ones((bottom - top, right - left), bool))


class DrawsRed(OutlineNetwork):
    """Draws what is red in the square, whatever was lit."""

    def forward(self, squares: torch.Tensor) -> torch.Tensor:
        """Return logits that are high where there is more red than blue."""
        assert squares.shape[1:] == (LAYERS, SIDE, SIDE)
        return 10.0 * (squares[:, 0] - squares[:, 2] - 0.4)


class Lights:
    """A family that always lights the same."""

    def __init__(self, heatmap: Heatmap, boxes: tuple[ScoredBox, ...] | None = None) -> None:
        self._evidence = Evidence(heatmap, boxes)

    def prepare(self, image: RgbImage) -> None:
        """Keep nothing."""

    def query(self, context: None, phrases: Sequence[str]) -> list[Evidence]:
        """Return the same for any phrase."""
        return [self._evidence for _ in phrases]


def outlined(lights: Lights, image: RgbImage, network: OutlineNetwork | None = None) -> Heatmap:
    family = DrawsOutlines(lights, network or DrawsRed(), least=0.3, edge=EDGE)
    return family.query(family.prepare(image), ["bar"])[0].heatmap


def boxes_of(heatmap: Heatmap) -> list[Box]:
    return [(one.left, one.top, one.right, one.bottom) for one in regions_of(heatmap, 0.3, EDGE)]


def test_of_half_a_thing_that_was_lit_the_whole_is_found() -> None:
    bar = (100, 80, 180, 100)
    after = outlined(Lights(heat((100, 80, 140, 100, 0.8))), picture(bar))
    (found,) = boxes_of(after)
    assert np.allclose(found, bar, atol=2)
    # Where it was lit it stays hottest: a point is taken there.
    assert float(after.max()) == pytest.approx(0.8)
    assert peak_point(after)[0] < 140


def test_what_was_lit_beside_a_thing_is_no_longer_of_it() -> None:
    bar = (100, 80, 150, 100)
    (found,) = boxes_of(outlined(Lights(heat((94, 70, 156, 110, 0.8))), picture(bar)))
    assert np.allclose(found, bar, atol=2)


def test_a_peak_that_lies_beside_the_thing_does_not_cost_its_score() -> None:
    bar = (100, 80, 150, 100)
    lights = Lights(heat((100, 70, 150, 100, 0.6), (120, 70, 130, 76, 0.9)))
    after = outlined(lights, picture(bar))
    assert float(after.max()) == pytest.approx(0.9)
    assert 80 <= peak_point(after)[1] <= 100


def test_one_thing_does_not_grow_into_another_that_was_found() -> None:
    bar = (100, 80, 180, 100)
    lights = Lights(heat((100, 80, 138, 100, 0.8), (142, 80, 180, 100, 0.7)))
    after = outlined(lights, picture(bar))
    left, right = sorted(boxes_of(after))
    assert left[2] <= right[0]
    assert sorted(round(one.score, 2) for one in find(after, 0.3, edge=EDGE).regions) == [0.7, 0.8]


def test_a_drawing_of_something_else_is_not_used() -> None:
    lit = heat((100, 80, 140, 100, 0.8))
    assert np.array_equal(outlined(Lights(lit), picture((150, 80, 180, 100))), lit)
    assert np.array_equal(outlined(Lights(lit), picture()), lit)


def test_only_one_piece_of_a_drawing_is_the_thing() -> None:
    image = picture((100, 80, 140, 100), (148, 80, 170, 100))
    (found,) = boxes_of(outlined(Lights(heat((100, 80, 136, 100, 0.8))), image))
    assert np.allclose(found, (100, 80, 140, 100), atol=2)


@pytest.mark.parametrize(
    "lights",
    [
        Lights(heat()),
        Lights(heat((100, 80, 140, 100, 0.29))),
        Lights(heat((10, 80, 10 + int(LARGEST * WIDTH) + 2, 100, 0.8))),
        Lights(heat((100, 80, 140, 100, 0.8)), (ScoredBox(100, 80, 140, 100, 0.8),)),
    ],
    ids=["nothing", "too faint", "too large", "boxes of its own"],
)
def test_what_is_not_drawn_stays_as_it_was(lights: Lights) -> None:
    before = lights.query(None, [""])[0].heatmap.copy()
    assert np.array_equal(outlined(lights, picture((100, 80, 180, 100))), before)


def test_the_heatmap_of_the_family_is_not_written_to() -> None:
    lights = Lights(heat((100, 80, 140, 100, 0.8)))
    before = lights.query(None, [""])[0].heatmap.copy()
    outlined(lights, picture((100, 80, 180, 100)))
    assert np.array_equal(lights.query(None, [""])[0].heatmap, before)


@given(
    st.integers(-20, 180),
    st.integers(-20, 90),
    st.integers(24, 200),
    st.sampled_from([0.6, 1.0, 2.0]),
)
def test_a_square_goes_out_of_a_map_and_back(left: int, top: int, side: int, scale: float) -> None:
    """Linear values survive, so that nothing is shifted by any part of a pixel."""
    values = np.add.outer(np.arange(HEIGHT) * 0.5, np.arange(WIDTH) * 0.25).astype(np.float32)
    window = Window(left, top, side, scale)
    place, back = window.onto_map(window.of_map(values, SIDE), HEIGHT, WIDTH)
    expected = values[place]
    assert back.shape == expected.shape
    # Away from the borders of square and map, where values are repeated or 0.
    rows, columns = (
        slice(max(4, 8 - place[n].start), min(size - 4, size - 8 + full - place[n].stop))
        for n, (size, full) in enumerate(zip(expected.shape, (HEIGHT, WIDTH), strict=True))
    )
    inner = expected[rows, columns]
    if inner.size:
        assert np.allclose(back[rows, columns], inner, atol=0.05 * max(1.0, side / scale / SIDE))


@given(st.integers(0, 330), st.integers(0, 180), st.sampled_from([0.6, 1.0, 2.0]))
def test_picture_heat_and_region_lie_on_each_other(left: int, top: int, scale: float) -> None:
    width, height = round(WIDTH / scale), round(HEIGHT / scale)
    thing = (left, top, left + 40, top + 30)
    box = tuple(round(value / scale) for value in thing)
    hot = np.zeros((height, width), np.float32)
    hot[box[1] : box[3], box[0] : box[2]] = 0.5
    mask = hot[box[1] : box[3], box[0] : box[2]] > 0
    around = Region(box[0], box[1], box[0] + mask.shape[1], box[1] + mask.shape[0], 0.5, mask)
    square = layers(picture(thing), hot, around, window_around(around, scale))
    assert square.shape == (SIDE, SIDE, LAYERS)
    lit, marked = (np.argwhere(square[..., n] > 115) for n in (3, 4))
    # Beyond the picture all is grey, and mixed with black at its border.
    colours = square[..., :3].astype(int)
    red = np.argwhere(colours[..., 0] - colours[..., 2] > 105)
    assert np.allclose(red.mean(axis=0), lit.mean(axis=0), atol=1.5)
    assert np.array_equal(lit, marked)
    assert int(square[..., 3].max()) == 255


def test_a_window_is_wider_than_its_region_and_around_it() -> None:
    window = window_around(region(100, 80, 140, 100), 0.5)
    assert window == Window(38, 23, 44, 0.5)
    wider = window.widened(1.5)
    assert wider == Window(27, 12, 66, 0.5)


def test_furniture_is_too_large_to_be_drawn() -> None:
    assert fits(region(0, 0, int(LARGEST * WIDTH), 20), WIDTH)
    assert not fits(region(0, 0, int(LARGEST * WIDTH) + 1, 20), WIDTH)


def test_regions_keep_their_heat_inside() -> None:
    warm = heat((100, 80, 140, 100, 0.5))
    warm[85:95, 110:120] = 0.8
    one = regions_of(warm, 0.3, EDGE)[0]
    window = window_around(one, 1.0)
    everything = np.full((1, SIDE, SIDE), -5.0, np.float32)
    place, _ = window.onto_map(everything[0], HEIGHT, WIDTH)
    drawn = window.of_map(np.where(warm >= 0.4, 5.0, -5.0), SIDE)[np.newaxis]
    after, found = redrawn(warm, [one], [window], drawn, EDGE)
    assert [(new.left, new.top, new.right, new.bottom) for new in found] == boxes_of(after)
    assert float(after[90, 115]) == pytest.approx(0.8)
    assert float(after[90, 130]) == pytest.approx(0.5)
    outside = np.ones(warm.shape, bool)
    outside[place] = False
    assert np.array_equal(after[outside], warm[outside])


def test_weights_are_written_and_read(tmp_path: Path) -> None:
    torch.manual_seed(1)
    network = OutlineNetwork().eval()
    weights.write(network, tmp_path)
    squares = torch.rand(2, LAYERS, SIDE, SIDE)
    with torch.inference_mode():
        before, after = network(squares), weights.read(tmp_path)(squares)
    assert before.shape == (2, SIDE, SIDE)
    assert torch.allclose(before, after, atol=0.02)


@pytest.mark.parametrize("damage", ["missing", "cut", "other"])
def test_damaged_weights_are_refused(damage: str, tmp_path: Path) -> None:
    from safetensors.torch import save_file

    if damage == "cut":
        weights.write(OutlineNetwork(), tmp_path)
        whole = (tmp_path / weights.FILE).read_bytes()
        (tmp_path / weights.FILE).write_bytes(whole[: len(whole) // 2])
    if damage == "other":
        save_file({"weight": torch.zeros(3)}, tmp_path / weights.FILE)
    with pytest.raises(ModelError, match="w2c train outline"):
        weights.read(tmp_path)


def test_a_picture_is_brought_to_the_width_of_the_training() -> None:
    seen = DrawsOutlines(Lights(heat()), DrawsRed(), least=0.3).prepare(picture())
    small, scale = brought_to_width(picture())
    assert seen.image.shape == small.shape
    assert seen.scale == scale


def test_a_picture_that_is_looked_at_twice_from_near_is_scaled_once() -> None:
    seen = LooksAgain(Lights(heat()), SecondLookNetwork(["bar"])).prepare(picture())
    twice = seen_near(Prepared(seen), picture())
    assert twice.context is seen
    assert twice.image is seen.image
    assert twice.scale == seen.scale


class Prepared:
    """A family that keeps what it was given."""

    def __init__(self, context: SeenNear[None]) -> None:
        self._context = context

    def prepare(self, image: RgbImage) -> SeenNear[None]:
        """Return it."""
        return self._context

    def query(self, context: SeenNear[None], phrases: Sequence[str]) -> list[Evidence]:
        """Return nothing hot."""
        return [Evidence(heat()) for _ in phrases]
