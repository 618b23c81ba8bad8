"""Points that are chosen only where a hand may go."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.conversing import BOOK, FIRST, World, first_words
from w2c.errors import DeadlineError, ModelError, RefusedError, UnavailableError
from w2c.messages import AllowedArea, Box, PhraseEvidence, PlaceGoal, PreviewReply
from w2c_dialogue.advice.mask import VETO, candidates, resampled, why_not, with_veto
from w2c_dialogue.advice.pointing import MaskedPointing
from w2c_dialogue.interfaces import Frame

WIDTH, HEIGHT = 1280, 720


def area_of(cells: np.ndarray) -> AllowedArea:
    return AllowedArea(
        stamp_ns=1, width=WIDTH, height=HEIGHT, cells=cells, reasons=["too steep", "no depth"]
    )


def thing(heatmap: np.ndarray | None, box: tuple[float, float, float, float]) -> PhraseEvidence:
    left, top, right, bottom = box
    return PhraseEvidence(
        phrase="book",
        found=True,
        score=1.0,
        point=None,
        boxes=[Box(left=left, top=top, right=right, bottom=bottom, score=1.0)],
        heatmap=heatmap,
    )


def square(top: int, left: int, side: int, shape: tuple[int, int] = (180, 320)) -> np.ndarray:
    heat = np.zeros(shape, np.uint8)
    heat[top : top + side, left : left + side] = 200
    return heat


codes = st.integers(0, 2**32 - 1).map(
    lambda seed: np.random.default_rng(seed).integers(0, 3, (36, 64)).astype(np.uint8)
)


@settings(max_examples=30)
@given(
    cells=codes, count=st.integers(1, 8), corner=st.tuples(st.integers(0, 99), st.integers(0, 99))
)
def test_every_candidate_is_on_the_thing_and_allowed(
    cells: np.ndarray, count: int, corner: tuple[int, int]
) -> None:
    heat = square(*corner, side=60)
    area = area_of(cells)
    found = candidates(thing(heat, (0, 0, 1, 1)), area, count)
    assert len(found) <= count
    assert [one.weight for one in found] == sorted((one.weight for one in found), reverse=True)
    for one in found:
        u, v = one.pixel
        assert heat[int(v / 4), int(u / 4)] == 200
        assert cells[int(v / 20), int(u / 20)] == 0
    pixels = [one.pixel for one in found]
    spacing = 0.15 * 60 * 4  # of the thing's 240 px
    for i, pixel in enumerate(pixels):
        for other in pixels[:i]:
            assert np.hypot(pixel[0] - other[0], pixel[1] - other[1]) >= spacing


@given(cells=codes, rows=st.sampled_from([36, 72, 180]), columns=st.sampled_from([64, 128, 320]))
def test_codes_at_a_multiple_of_the_size_are_the_same_codes(
    cells: np.ndarray, rows: int, columns: int
) -> None:
    again = resampled(resampled(cells, rows, columns), 36, 64)
    np.testing.assert_array_equal(again, cells)


def test_without_a_mask_it_is_the_middle_of_the_thing() -> None:
    """The same rule as grounding's own: hot and far from the edge."""
    (best,) = candidates(
        thing(square(60, 100, 41), (0, 0, 1, 1)), area_of(np.zeros((36, 64), np.uint8)), 1
    )
    assert best.pixel == (120.5 * 4, 80.5 * 4)


def test_the_border_of_the_allowed_area_is_an_edge() -> None:
    cells = np.zeros((180, 320), np.uint8)
    cells[:, :130] = 1  # all but the right 10 of 40 columns
    (best,) = candidates(thing(square(60, 100, 40), (0, 0, 1, 1)), area_of(cells), 1)
    assert 130 * 4 + 12 < best.pixel[0] < 140 * 4 - 12


def test_nothing_allowed_has_reasons_with_their_share() -> None:
    cells = np.full((180, 320), 1, np.uint8)
    cells[90:] = 2
    seen = thing(square(60, 100, 40), (0, 0, 1, 1))
    assert candidates(seen, area_of(cells), 3) == []
    assert why_not(seen, area_of(cells)) == "too steep (75%), no depth (25%)"


def test_a_thing_without_a_heatmap_is_its_box() -> None:
    seen = thing(None, (400, 300, 600, 420))
    (best,) = candidates(seen, area_of(np.zeros((72, 128), np.uint8)), 1)
    assert 400 < best.pixel[0] < 600
    assert 300 < best.pixel[1] < 420


@pytest.mark.parametrize("with_heatmap", [True, False])
def test_what_must_not_be_touched_is_cut_out_with_its_margin(with_heatmap: bool) -> None:
    heat = square(60, 100, 40) if with_heatmap else None
    seen = thing(heat, (400, 240, 560, 400))
    area = with_veto(area_of(np.zeros((72, 128), np.uint8)), [seen], share=0.3, margin=50.0)
    assert area.reasons[-1] == VETO
    veto = area.cells == 3
    assert veto[24:40, 40:56].all()
    assert veto[32, 36]  # 40 px beside it
    assert not veto[32, 32]  # 80 px beside it
    assert not veto[32, 63]


def test_one_hot_pixel_of_a_person_is_enough() -> None:
    """A cell that covers several pixels of the heatmap must not average them away."""
    heat = np.zeros((180, 320), np.uint8)
    heat[101, 203] = 255
    area = with_veto(area_of(np.zeros((18, 32), np.uint8)), [thing(heat, (0, 0, 1, 1))], 0.3, 0.0)
    assert area.cells[10, 20] == 3


def test_what_is_not_found_cuts_nothing_out() -> None:
    seen = PhraseEvidence(
        phrase="person", found=False, score=0.1, point=None, boxes=[], heatmap=square(60, 100, 40)
    )
    area = area_of(np.zeros((72, 128), np.uint8))
    assert with_veto(area, [seen], 0.3, 50.0) is area


# --- in a conversation


class Masked(World):
    """A dialogue that points only where a hand may go."""

    budget_s = 0.5

    def masked_pointing(self) -> MaskedPointing:
        return MaskedPointing(
            self.guard, self.limbs, self.areas.append, self.clock, budget_s=self.budget_s
        )


def test_a_point_moves_to_where_a_hand_may_go_and_the_area_is_shown() -> None:
    world = Masked(**first_words())
    world.lift.cells[:, :55] = 1  # the left 150 of the book's 200 px
    turn = world.say(FIRST)
    assert turn.target is not None
    assert 550 < turn.target.u < 600
    assert 300 < turn.target.v < 420
    assert turn.target.warning == ""
    assert [area.stamp_ns for area in world.areas] == [100]


def test_nothing_allowed_is_an_answer_with_the_reason_and_the_point_without_it() -> None:
    world = Masked(**first_words())
    world.lift.cells[:] = 1
    turn = world.say(FIRST)
    assert turn.ok
    assert turn.target is not None
    assert (turn.target.u, turn.target.v) == (500, 360)  # grounding's own
    assert "Nothing on 'book' is allowed: too steep (100%)" in turn.reply
    assert not world.controller.previewed


def test_what_must_not_be_touched_is_not_pointed_at() -> None:
    world = Masked(**first_words())
    world.grounding.things["person"] = (400, 300, 480, 420)
    turn = world.say(FIRST)
    assert turn.target is not None
    assert turn.target.u > 530
    assert world.areas[0].reasons[-1] == VETO


def test_what_is_only_reached_for_need_not_be_flat_but_a_veto_holds() -> None:
    world = Masked(**{**first_words(), "effector": [{"effector": "left_hand", "task": "reach"}]})
    world.lift.cells[:] = 1
    world.grounding.things["person"] = (400, 300, 480, 420)
    turn = world.say(FIRST)
    assert turn.target is not None
    assert turn.target.u > 530
    assert turn.target.warning == ""
    assert world.areas == []  # the shaded area is for hands that lean
    assert world.controller.previewed[0].task == "reach"


def test_words_for_a_limb_that_cannot_be_read_leave_the_best_allowed_point() -> None:
    world = Masked(**{**first_words(), "effector": [ModelError("no such limb")]})
    world.lift.cells[:, :55] = 1
    turn = world.say(FIRST)
    assert turn.target is not None
    assert turn.target.u > 550
    assert "whether I get there (no such limb)" in turn.reply


def test_the_first_candidate_within_reach_is_taken() -> None:
    world = Masked(**first_words())
    preview = world.controller.preview

    def near_only(goal: PlaceGoal) -> PreviewReply:
        preview(goal)
        if goal.point[1] < 0.14:  # the picture's left is the robot's left
            return PreviewReply(reachable=False, distance=0.1, reason="10 cm short")
        return PreviewReply(reachable=True, distance=0.0)

    world.controller.preview = near_only  # type: ignore[method-assign]
    turn = world.say(FIRST)
    assert turn.target is not None
    assert turn.target.point is not None
    assert turn.target.point[1] >= 0.14
    assert turn.target.warning == ""
    assert all(goal.end_effector == "right_hand" for goal in world.controller.previewed)


def test_allowed_but_out_of_reach_is_an_answer_too() -> None:
    world = Masked(**first_words())
    world.controller.outlook = PreviewReply(reachable=False, distance=0.1, reason="10 cm short")
    turn = world.say(FIRST)
    assert turn.target is not None
    assert (turn.target.u, turn.target.v) == (500, 360)
    assert "within reach: 10 cm short" in turn.reply
    assert 1 < len(world.controller.previewed) <= 6


def test_time_ends_the_search_and_it_is_said() -> None:
    world = Masked(**first_words())
    world.controller.outlook = PreviewReply(reachable=False, distance=0.1, reason="10 cm short")
    preview = world.controller.preview

    def slow(goal: PlaceGoal) -> PreviewReply:
        world.clock.set(world.clock.now_ns() + 400_000_000)
        return preview(goal)

    world.controller.preview = slow  # type: ignore[method-assign]
    turn = world.say(FIRST)
    assert len(world.controller.previewed) == 2
    assert "ran out of time" in turn.reply


def test_one_point_is_tried_however_long_words_and_area_took() -> None:
    world = Masked(**first_words())
    ask = world.lift.allowed

    def slow(frame: Frame) -> AllowedArea:
        world.clock.set(world.clock.now_ns() + 5_000_000_000)
        return ask(frame)

    world.lift.allowed = slow  # type: ignore[method-assign]
    turn = world.say(FIRST)
    assert len(world.controller.previewed) == 1
    assert turn.target is not None
    assert turn.target.warning == ""


@pytest.mark.parametrize("error", [UnavailableError("gone"), DeadlineError("late")])
def test_a_mask_that_does_not_come_leaves_the_point_and_is_said(error: Exception) -> None:
    world = Masked(**first_words())
    world.lift.allowed_error = error  # type: ignore[assignment]
    turn = world.say(FIRST)
    assert turn.target is not None
    assert (turn.target.u, turn.target.v) == (500, 360)
    assert "could not see where a hand may go" in turn.reply
    assert world.areas == []


def test_a_controller_that_does_not_answer_leaves_the_best_allowed_point() -> None:
    world = Masked(**first_words())
    world.lift.cells[:, :55] = 1
    world.controller.preview_error = UnavailableError("starting")
    turn = world.say(FIRST)
    assert turn.target is not None
    assert turn.target.u > 550
    assert "whether I get there" in turn.reply


def test_a_candidate_without_depth_is_passed_over() -> None:
    world = Masked(**first_words())
    lift = world.lift.lift

    def holes(u: float, v: float, frame: Frame) -> object:
        if u < 480:
            raise RefusedError("no depth at the pixel")
        return lift(u, v, frame)

    world.lift.lift = holes  # type: ignore[assignment]
    world.lift.cells[:, 49:55] = 1
    turn = world.say(FIRST)
    assert turn.target is not None
    assert turn.target.u >= 480


def test_off_by_default_nobody_is_asked_for_an_area() -> None:
    world = World(**first_words())
    world.lift.allowed_error = UnavailableError("gone")
    turn = world.say(FIRST)
    assert turn.target is not None
    assert turn.target.warning == ""
    assert BOOK[0] < turn.target.u < BOOK[2]
