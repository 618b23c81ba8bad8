"""The things of a picture: from what the network answers to regions of a heatmap."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from w2c.errors import ModelError
from w2c_grounding.clipseg import ClipSegContext
from w2c_grounding.evidence import find, regions_of
from w2c_grounding.folding import folded
from w2c_grounding.things import weights
from w2c_grounding.things.finder import ThingFinder
from w2c_grounding.things.network import FINER, ThingsNetwork
from w2c_grounding.things.proposals import MOST, SURE, Thing, things_of
from w2c_grounding.things.territory import divided, lit, outside

EDGE = 0.3
ROWS = 10
HEIGHT, WIDTH = 100, 200
Box = tuple[float, float, float, float]


def places(rows: slice, columns: slice) -> npt.NDArray[np.bool_]:
    mask = np.zeros((ROWS, ROWS), np.bool_)
    mask[rows, columns] = True
    return mask


def thing(left: int, top: int, right: int, bottom: int) -> Thing:
    """Return what is seen all over its box, in tenths of the picture."""
    box = (left / ROWS, top / ROWS, right / ROWS, bottom / ROWS)
    return Thing(box, places(slice(top, bottom), slice(left, right)), 0.9)


def answers(
    *seen: tuple[Box, tuple[slice, slice], float],
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Return answers of a network that sees boxes at places, and how well it says they fit."""
    there = np.full((ROWS, ROWS), -5.0, np.float32)
    fits = np.full((ROWS, ROWS), -5.0, np.float32)
    boxes = np.tile(np.array([0.0, 0.0, 1.0, 1.0], np.float32), (ROWS, ROWS, 1))
    for box, where, well in seen:
        there[where] = 5.0
        fits[where] = well
        boxes[where] = box
    return there, fits, boxes


LEFT_BOX, RIGHT_BOX = (0.1, 0.2, 0.4, 0.6), (0.5, 0.2, 0.9, 0.8)
LEFT, RIGHT = np.s_[2:6, 1:4], np.s_[2:8, 5:9]


def test_places_with_the_same_box_are_one_thing() -> None:
    found = things_of(*answers((LEFT_BOX, LEFT, 1.0), (RIGHT_BOX, RIGHT, 2.0)))
    assert len(found) == 2
    assert np.allclose(found[0].box, RIGHT_BOX)
    assert np.allclose(found[1].box, LEFT_BOX)
    assert np.array_equal(found[0].places, places(*RIGHT))
    assert np.array_equal(found[1].places, places(*LEFT))


def test_the_box_is_a_mean_of_those_that_agree() -> None:
    near = (0.5, 0.2, 0.9, 0.84)
    (found,) = things_of(*answers((RIGHT_BOX, np.s_[2:5, 5:9], 2.0), (near, np.s_[5:8, 5:9], 2.0)))
    assert found.box == pytest.approx((0.5, 0.2, 0.9, 0.82))
    assert np.array_equal(found.places, places(*RIGHT))


HALF_BOX = (0.5, 0.2, 0.9, 0.55)


def test_a_fringe_with_half_of_the_box_belongs_to_the_thing() -> None:
    (found,) = things_of(
        *answers((RIGHT_BOX, np.s_[2:7, 5:9], 2.0), (HALF_BOX, np.s_[7:8, 5:9], 0.0))
    )
    assert found.box == pytest.approx(RIGHT_BOX)
    assert np.array_equal(found.places, places(*RIGHT))


@pytest.mark.parametrize("surer", ["what lies on it", "what it lies on"])
def test_what_lies_on_a_thing_and_hides_half_of_it_is_another(surer: str) -> None:
    on, below = (2.0, 1.0) if surer == "what lies on it" else (1.0, 2.0)
    found = things_of(
        *answers((HALF_BOX, np.s_[2:5, 5:9], on), (RIGHT_BOX, np.s_[5:8, 5:9], below))
    )
    lower, higher = sorted((one.box for one in found), key=lambda box: box[3], reverse=True)
    assert lower == pytest.approx(RIGHT_BOX)
    assert higher == pytest.approx(HALF_BOX)


def test_what_is_seen_nowhere_or_fits_badly_is_no_thing() -> None:
    assert things_of(*answers()) == ()
    assert things_of(*answers((LEFT_BOX, LEFT, -3.0))) == ()


def test_boxes_end_at_the_border() -> None:
    (found,) = things_of(*answers(((-0.2, 0.3, 0.4, 1.7), LEFT, 2.0)))
    assert found.box == pytest.approx((0.0, 0.3, 0.4, 1.0))


def test_what_ends_next_to_the_border_is_cut_off_by_it() -> None:
    (found,) = things_of(*answers(((0.004, 0.3, 0.4, 0.997), LEFT, 2.0)))
    assert found.box == pytest.approx((0.0, 0.3, 0.4, 1.0))
    (found,) = things_of(*answers(((0.02, 0.3, 0.4, 0.98), LEFT, 2.0)))
    assert found.box == pytest.approx((0.02, 0.3, 0.4, 0.98))


@given(seed=st.integers(0, 10_000), spread=st.floats(0.1, 50.0))
def test_things_share_no_place_and_lie_within_the_picture(seed: int, spread: float) -> None:
    rng = np.random.default_rng(seed)
    there, fits = rng.normal(0.0, spread, (2, ROWS, ROWS)).astype(np.float32)
    corners = rng.uniform(-0.5, 1.5, (ROWS, ROWS, 4)).astype(np.float32)
    boxes = np.concatenate([corners[..., :2], corners[..., :2] + np.abs(corners[..., 2:])], axis=2)
    found = things_of(there, fits, boxes)
    assert len(found) <= MOST
    shown = [one.places for one in found]
    assert np.count_nonzero(np.any(shown, axis=0)) == sum(np.count_nonzero(one) for one in shown)
    scores = [one.score for one in found]
    assert scores == sorted(scores, reverse=True)
    assert all(SURE <= score <= 1.0 for score in scores)
    for one in found:
        left, top, right, bottom = one.box
        assert 0.0 <= left <= right <= 1.0
        assert 0.0 <= top <= bottom <= 1.0
    territory = divided(found, HEIGHT, WIDTH)
    count = np.zeros((HEIGHT, WIDTH), int)
    for ground in territory.grounds:
        assert ground.mine.shape == count[ground.window].shape
        count[ground.window] += ground.mine
        assert not (ground.seen & ~ground.mine).any()
    assert count.max(initial=0) <= 1
    heatmap = rng.uniform(0.0, 1.0, (HEIGHT, WIDTH)).astype(np.float32)
    raised, regions = lit(heatmap, territory, EDGE)
    assert (raised >= heatmap).all()
    assert all(
        one.score == raised[one.top : one.bottom, one.left : one.right][one.mask].max()
        for one in regions
    )


def test_things_that_touch_are_two_regions() -> None:
    territory = divided([thing(1, 2, 5, 8), thing(5, 2, 9, 8)], HEIGHT, WIDTH)
    raised, regions = lit(np.full((HEIGHT, WIDTH), 0.8, np.float32), territory, EDGE)
    assert [(one.left, one.right) for one in regions] == [(20, 100), (100, 180)]
    hot = np.zeros_like(raised)
    for one in regions:
        hot[one.top : one.bottom, one.left : one.right][one.mask] = one.score
    assert len(regions_of(hot, 0.5, EDGE)) == 2
    assert np.count_nonzero(hot) > 0.95 * 60 * 160


def test_what_lies_on_a_thing_is_no_part_of_it() -> None:
    large, small = thing(1, 1, 9, 9), thing(4, 4, 6, 6)
    rest = Thing(large.box, large.places & ~small.places, 0.95)
    territory = divided([rest, small], HEIGHT, WIDTH)
    cup = np.zeros((HEIGHT, WIDTH), np.float32)
    cup[42:58, 85:115] = 0.9
    _, (tray, mug) = lit(cup, territory, EDGE)
    assert mug.score == pytest.approx(0.9)
    assert tray.score < 0.01
    assert not tray.mask[50 - tray.top, 100 - tray.left]
    assert tray.mask[20 - tray.top, 100 - tray.left]


def test_where_nothing_is_seen_a_thing_is_where_it_is_hot() -> None:
    half = Thing((0.1, 0.2, 0.9, 0.8), places(slice(2, 8), slice(1, 5)), 0.9)
    heatmap = np.zeros((HEIGHT, WIDTH), np.float32)
    heatmap[40:60, 60:170] = 0.6
    heatmap[40:60, 150:170] = 0.1
    raised, (region,) = lit(heatmap, divided([half], HEIGHT, WIDTH), EDGE)
    assert region.score == pytest.approx(0.6)
    assert region.mask[50 - region.top, 140 - region.left], "hot"
    assert not region.mask[50 - region.top, 160 - region.left], "neither seen nor hot"
    assert region.mask[25 - region.top, 30 - region.left], "seen"
    # What is seen is of the region although it is cold, and so it is found.
    assert EDGE * 0.6 < raised[25, 30] < 0.6
    assert heatmap[25, 30] == 0.0, "the heatmap of the family is not written to"
    assert len(find(raised, 0.5, edge=EDGE).regions) == 1


def test_heat_beside_things_is_of_no_thing() -> None:
    territory = divided([thing(1, 2, 5, 8)], HEIGHT, WIDTH)
    rest = outside(np.full((HEIGHT, WIDTH), 0.7, np.float32), territory)
    assert rest[50, 60] == 0.0
    assert rest[50, 101] == 0.0, "the glow of a thing"
    assert rest[50, 110] == np.float32(0.7)


def context(width: int = 8, cells: int = 4) -> ClipSegContext:
    generator = torch.Generator().manual_seed(1)
    activations = tuple(
        torch.randn(1, 1 + cells * cells, width, generator=generator) for _ in range(2)
    )
    return ClipSegContext(320, 180, activations, torch.randn(1, 3, 64, 64, generator=generator))


def test_a_network_answers_at_places_finer_than_patches() -> None:
    network = ThingsNetwork(16).eval()
    seen = context()
    there, fits, boxes = network(seen.activations, seen.pixels)
    assert there.shape == fits.shape == (1, 4 * FINER, 4 * FINER)
    assert boxes.shape == (1, 4 * FINER, 4 * FINER, 4)
    middle = (torch.arange(4 * FINER) + 0.5) / (4 * FINER)
    assert bool((boxes[0, ..., 0] < middle).all())
    assert bool((boxes[0, ..., 2] > middle).all())
    assert bool((boxes[0, ..., 1] < middle[:, None]).all())
    assert bool((boxes[0, ..., 3] > middle[:, None]).all())


def test_weights_are_written_and_read(tmp_path: Path) -> None:
    network = ThingsNetwork(16).eval()
    weights.write(network, tmp_path)
    again = weights.read(tmp_path)
    seen = context()
    with torch.inference_mode():
        before, after = (one(seen.activations, seen.pixels)[0] for one in (network, again))
    assert torch.allclose(before, after, atol=0.05)
    assert (tmp_path / weights.FILE).stat().st_mode & 0o044 == 0o044
    assert isinstance(ThingFinder(again)(seen), tuple)


def test_norms_are_folded_and_the_answers_stay() -> None:
    torch.manual_seed(2)
    network = ThingsNetwork(16)
    seen = context()
    for _ in range(3):  # the norms have seen something
        network(seen.activations, seen.pixels)
    network.eval()
    fewer = folded(network)
    assert not [part for part in fewer.modules() if isinstance(part, torch.nn.BatchNorm2d)]
    with torch.inference_mode():
        for before, after in zip(
            *(one(seen.activations, seen.pixels) for one in (network, fewer)), strict=True
        ):
            assert torch.allclose(before, after, atol=1e-4)


@pytest.mark.parametrize("damage", ["missing", "cut", "no width"])
def test_damaged_weights_are_refused(damage: str, tmp_path: Path) -> None:
    weights.write(ThingsNetwork(16), tmp_path)
    file = tmp_path / weights.FILE
    if damage == "missing":
        file.unlink()
    elif damage == "cut":
        file.write_bytes(file.read_bytes()[:1000])
    else:
        file.write_bytes(file.read_bytes().replace(b'"width":"16"', b'"width":"1x"'))
    with pytest.raises(ModelError, match="w2c train things"):
        weights.read(tmp_path)


def test_the_finder_says_what_the_network_sees() -> None:
    class SeesTwo(ThingsNetwork):
        def forward(
            self, activations: Sequence[torch.Tensor], pixels: torch.Tensor
        ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
            seen = answers((LEFT_BOX, LEFT, 1.0), (RIGHT_BOX, RIGHT, 2.0))
            there, fits, boxes = (torch.from_numpy(one)[None] for one in seen)
            return there, fits, boxes

    found = ThingFinder(SeesTwo(16))(context())
    assert [one.box[0] for one in found] == pytest.approx([0.5, 0.1])
