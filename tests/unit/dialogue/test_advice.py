"""What is found out about a target after it is shown, and what becomes of checks that fail."""

from collections.abc import Sequence

import pytest

from support.conversing import BOOK, FIRST, World, first_words
from w2c.errors import DeadlineError, ModelError, UnavailableError
from w2c.messages import Advice, ConfirmRequest, FitnessVerdict, PointRequest, PreviewReply, Remark
from w2c_dialogue.advice.advisor import Advisor
from w2c_dialogue.advice.checks import Checks
from w2c_dialogue.conversation import Shown


class Desk:
    """An advisor of the dialogue of a world, without its thread."""

    def __init__(self, world: World, deadline_s: float = 5.0) -> None:
        self.world = world
        self.told: list[Advice] = []
        checks = Checks(
            world.guard,
            world.watch,
            world.limbs,
            world.model,
            world.controller,
            fragile=("glass", "cloth"),
            share=0.3,
        )
        self.advisor = Advisor(
            checks, self.told.append, self.shown_id, world.clock, deadline_s=deadline_s
        )

    def shown_id(self) -> str:
        shown = self.world.dialogue.shown()
        return shown.target.target_id if shown else ""

    def advise(self, since_ns: int | None = None) -> Advice:
        """Advise on what is shown now, and return the last word."""
        self.advisor.advise(self.shown(), since_ns or self.world.clock.now_ns())
        return self.told[-1]

    def shown(self) -> Shown:
        shown = self.world.dialogue.shown()
        assert shown is not None
        return shown


def proposed(**answers: Sequence[object]) -> World:
    world = World(**{**first_words(), **answers})
    world.grounding.words = {"person", "hand", "face", "child", "dog", "cat", "flame", "glass"}
    world.say(FIRST)
    return world


def of_kind(advice: Advice, kind: str) -> list[Remark]:
    return [remark for remark in advice.remarks if remark.kind == kind]


def test_a_good_target_is_said_to_be_reachable_and_nothing_speaks_against_it() -> None:
    world = proposed()
    advice = Desk(world).advise()
    assert advice.target_id == world.shown
    assert advice.frame_stamp_ns == 100
    assert [(remark.kind, remark.level) for remark in advice.remarks] == [
        ("surface", "fine"),
        ("reach", "fine"),
    ]
    (reach,) = of_kind(advice, "reach")
    assert reach.text == "my right hand can lean there from here"
    assert (reach.value, reach.unit, reach.source) == (0.001, "m", "controller")
    assert advice.pending == []
    assert advice.refusal == ""


def test_each_check_is_told_as_soon_as_it_is_made() -> None:
    desk = Desk(proposed())
    desk.advise()
    assert [advice.pending for advice in desk.told] == [
        ["material", "surface", "reach"],
        ["surface", "reach"],
        ["reach"],
        [],
    ]


def test_a_point_out_of_reach_is_told_with_reason_and_distance_and_stays_the_operators_choice() -> (
    None
):
    world = proposed(effector=[{"effector": "left_hand", "task": "reach"}])
    world.controller.outlook = PreviewReply(
        reachable=False, distance=0.08, reason="the left hand ends 8.0 cm short of the point"
    )
    advice = Desk(world).advise()
    (reach,) = of_kind(advice, "reach")
    assert reach.level == "caution"
    assert "cannot reach there from here: the left hand ends 8.0 cm short" in reach.text
    assert reach.value == 0.08
    assert advice.refusal == ""
    assert world.controller.previewed[0].end_effector == "left_hand"
    assert not world.controller.goals


def test_a_place_that_can_be_reached_is_told_with_what_to_beware_of() -> None:
    world = proposed(effector=[{"effector": "left_hand", "task": "reach"}])
    world.controller.outlook = PreviewReply(
        reachable=True, distance=0.0, reason="the robot leans 9.0 cm ahead of its feet"
    )
    (reach,) = of_kind(Desk(world).advise(), "reach")
    assert reach.level == "caution"
    assert reach.text.endswith(
        "can reach there from here, but the robot leans 9.0 cm ahead of its feet"
    )


def test_a_fragile_thing_is_told_with_its_word_and_its_heat() -> None:
    world = proposed()
    world.grounding.things["glass"] = BOOK
    advice = Desk(world).advise()
    (material,) = of_kind(advice, "material")
    assert material.text == "looks like glass: may break under my weight"
    assert (material.level, material.source) == ("caution", "grounding")
    assert material.value == pytest.approx(0.9)
    assert material.limit == pytest.approx(0.27)


def test_a_fragile_thing_that_is_named_needs_no_look() -> None:
    text = "lean on the glass table"
    world = World(analyze=[{"position": "absolute", "objects": ["4-5"]}])
    world.grounding.things["glass table"] = BOOK
    world.say(text)
    world.grounding.error = UnavailableError("nobody serves it")
    advice = Desk(world).advise()
    (material,) = of_kind(advice, "material")
    assert material.source == "operator"
    assert material.text == "glass: may break under my weight"
    assert {item.check for item in advice.unchecked} == {"veto", "material"}


def test_a_veto_is_told_with_what_confirm_would_say() -> None:
    world = proposed()
    world.grounding.things["person"] = BOOK
    advice = Desk(world).advise()
    (veto,) = of_kind(advice, "veto")
    assert veto.level == "veto"
    assert veto.value == pytest.approx(0.9)
    assert advice.refusal == veto.text
    assert "'person'" in advice.refusal


def test_words_that_the_model_does_not_know_are_told_as_unchecked() -> None:
    world = proposed()
    world.grounding.words -= {"flame"}
    advice = Desk(world).advise()
    reasons = {item.check: item.reason for item in advice.unchecked}
    assert "'flame'" in reasons["veto"]
    assert advice.refusal == ""


def test_a_silent_grounding_leaves_confirm_open_because_it_looks_again() -> None:
    world = proposed()
    world.grounding.error = DeadlineError("no reply within 5 s")
    advice = Desk(world).advise()
    assert advice.refusal == ""
    assert [item.check for item in advice.unchecked] == ["veto", "material"]
    assert [remark.kind for remark in advice.remarks] == ["surface", "reach"]


@pytest.mark.parametrize("error", [UnavailableError("starting"), DeadlineError("late")])
def test_a_controller_that_does_not_answer_is_an_unchecked_reach(error: Exception) -> None:
    world = proposed()
    world.controller.preview_error = error  # type: ignore[assignment]
    advice = Desk(world).advise()
    assert [(item.check, item.reason) for item in advice.unchecked][-1] == ("reach", str(error))


def test_a_language_model_that_fails_is_an_unchecked_reach() -> None:
    world = proposed(effector=[ModelError("no such limb")])
    advice = Desk(world).advise()
    assert [item.check for item in advice.unchecked] == ["surface", "reach"]


def test_an_unfit_surface_is_told_check_by_check_and_stays_the_operators_choice() -> None:
    world = World(**first_words())
    world.lift.verdicts = [
        FitnessVerdict(check="flat", fit=True, reason="flat", value=0.001, limit=0.004),
        FitnessVerdict(check="large", fit=False, reason="too small", value=0.01, limit=0.03),
        FitnessVerdict(check="slope", fit=False, reason="too steep", value=0.7, limit=0.54),
    ]
    world.say(FIRST)
    advice = Desk(world).advise()
    found = [(r.text, r.level, r.value, r.limit, r.unit) for r in of_kind(advice, "surface")]
    assert found == [
        ("too small", "caution", 0.01, 0.03, "m"),
        ("too steep", "caution", 0.7, 0.54, "rad"),
    ]
    assert advice.refusal == ""


def test_what_is_only_reached_for_need_not_carry_a_hand() -> None:
    world = proposed(effector=[{"effector": "right_hand", "task": "reach"}])
    advice = Desk(world).advise()
    assert of_kind(advice, "surface") == []
    assert "surface" not in {item.check for item in advice.unchecked}


def test_a_place_for_a_foot_is_not_judged_as_one_for_a_hand() -> None:
    world = proposed(effector=[{"effector": "left_foot", "task": "contact"}])
    advice = Desk(world).advise()
    assert of_kind(advice, "surface") == []
    assert "foot" in {item.check: item.reason for item in advice.unchecked}["surface"]


def test_a_target_without_depth_has_no_reach() -> None:
    world = proposed()
    world.lift.error = DeadlineError("perception is silent")
    turn = world.dialogue.point(PointRequest(u=500, v=360))
    assert turn.target is not None
    advice = Desk(world).advise()
    assert advice.target_id == turn.target.target_id
    assert "depth" in advice.unchecked[-1].reason


def test_no_check_begins_after_the_deadline() -> None:
    world = proposed()
    world.clock.set(20_000_000_000)
    advice = Desk(world, deadline_s=5.0).advise(since_ns=1)
    assert {item.check for item in advice.unchecked} == {"veto", "material", "surface", "reach"}
    assert "limit 5 s" in advice.unchecked[0].reason
    assert not world.grounding.watched
    assert not world.controller.previewed


def test_advice_on_a_target_that_is_no_longer_shown_is_dropped() -> None:
    world = proposed()
    desk = Desk(world)
    old = desk.shown()
    world.dialogue.point(PointRequest(u=100, v=100))
    desk.advisor.advise(old, 1)
    assert desk.told == []
    assert not world.grounding.watched


def test_advice_ends_with_the_target_even_in_the_middle_of_a_check() -> None:
    world = proposed()
    desk = Desk(world)
    find = world.grounding.find

    def point_meanwhile(*arguments: object) -> object:
        world.dialogue.point(PointRequest(u=100, v=100))
        return find(*arguments)  # type: ignore[arg-type]

    world.watch._find = point_meanwhile  # type: ignore[assignment]
    desk.advisor.advise(desk.shown(), 1)
    assert desk.told == []


def test_the_limb_is_heard_once_for_advice_and_confirmation() -> None:
    world = proposed()
    Desk(world).advise()
    assert world.dialogue.confirm(ConfirmRequest(target_id=world.shown)).ok
    asked = [question.task for question in world.model.questions]
    assert asked.count("effector") == 1
