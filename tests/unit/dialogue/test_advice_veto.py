"""What the veto list names is never touched, whoever points at it, and whatever else fails."""

import threading
from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes.dialogue_world import KnownThings
from support.conversing import BOOK, FIRST, STAY, World, first_words
from w2c.errors import ConfigError, DeadlineError, RemoteError, UnavailableError
from w2c.messages import ConfirmRequest, GroundingReply, PointRequest, Turn
from w2c_dialogue.advice.guard import Guard
from w2c_dialogue.advice.veto import UncheckedVeto, Verdict
from w2c_dialogue.advice.watch import Watch
from w2c_dialogue.advice.wordlist import VETOED, check_phrases, fragility, named_in
from w2c_dialogue.interfaces import Frame

FRAME = Frame(7, 1280, 720, b"jpeg")


def confirm(world: World, target_id: str = "") -> Turn:
    return world.dialogue.confirm(ConfirmRequest(target_id=target_id or world.shown))


def test_a_target_on_a_person_cannot_be_confirmed_and_nothing_moves() -> None:
    world = World(**first_words())
    world.grounding.things["person"] = BOOK
    world.say(FIRST)
    turn = confirm(world)
    assert not turn.ok
    assert "'person'" in turn.reply
    assert "0.90, limit 0.27" in turn.reply
    assert not world.controller.goals
    assert not world.controller.previewed


def test_the_veto_holds_for_a_spoken_yes_too() -> None:
    world = World(**{**first_words(), "select": ["prediction", "confirmation"]})
    world.grounding.things["person"] = BOOK
    world.say(FIRST)
    assert not world.say("that's perfect").ok
    assert not world.controller.goals


def test_a_click_on_a_person_cannot_be_confirmed() -> None:
    world = World()
    world.grounding.things["child"] = (900, 200, 960, 280)
    turn = world.dialogue.point(PointRequest(u=930, v=240))
    assert turn.target is not None
    assert not confirm(world, turn.target.target_id).ok
    beside = world.dialogue.point(PointRequest(u=800, v=240))
    assert beside.target is not None
    assert confirm(world, beside.target.target_id).ok


def test_a_correction_moves_a_target_onto_a_person_and_off_again() -> None:
    answers = {"select": ["prediction", "correction", "correction"]}
    steps = {"correct": [{"x": "target.u+300", "y": STAY["y"]}, {"x": "500", "y": STAY["y"]}]}
    world = World(**{**first_words(), **answers, **steps})
    world.grounding.things["face"] = (760, 300, 840, 420)
    world.say(FIRST)
    assert world.say("30 cm to the right").ok
    assert "'face'" in confirm(world).reply
    assert world.say("back to the left").ok
    assert confirm(world).ok


def test_a_hand_beside_a_person_keeps_the_margin() -> None:
    """The margin is 5 cm, 50 px where there is no depth scale."""
    for u, allowed in ((640, False), (660, True)):
        world = World()
        world.grounding.things["person"] = BOOK  # ends at 600
        turn = world.dialogue.point(PointRequest(u=u, v=360))
        assert turn.target is not None
        assert confirm(world, turn.target.target_id).ok is allowed


def test_a_named_person_is_vetoed_though_the_model_does_not_know_the_word() -> None:
    text = "lean on the person's shoulder"
    world = World(analyze=[{"position": "absolute", "objects": ["4-5"]}])
    world.grounding.things["person's shoulder"] = BOOK
    world.say(text)
    turn = confirm(world)
    assert not turn.ok
    assert "named 'person'" in turn.reply


def test_beside_a_named_person_is_no_veto() -> None:
    world = World(
        analyze=[{"position": "relative", "objects": ["6-6"]}],
        relative=[{"x": "a.left-100", "y": "a.v"}],
    )
    world.grounding.things["person"] = BOOK
    world.say("to the left of the person")
    assert confirm(world).ok


def test_a_word_the_model_does_not_know_is_said_once_and_not_checked(
    caplog: pytest.LogCaptureFixture,
) -> None:
    world = World(**first_words())
    world.grounding.words = {"person", "hand", "face", "child", "dog", "cat"}
    world.say(FIRST)
    assert confirm(world).ok
    assert world.watch.unknown == {"flame": ("flame",), "glass": ("glass",)}
    warnings = [record for record in caplog.records if "does not know" in record.getMessage()]
    assert len(warnings) == 1
    shown = world.watch.look(Frame(8, 1280, 720, b"other"))
    assert "flame" not in world.grounding.watched[-1][1]  # it would only take time
    assert set(shown.unknown) == {"flame", "glass"}
    assert len([r for r in caplog.records if "does not know" in r.getMessage()]) == 1


@pytest.mark.parametrize(
    "error", [UnavailableError("nobody serves it"), DeadlineError("no reply within 5 s")]
)
def test_nothing_moves_where_grounding_cannot_look(error: Exception) -> None:
    world = World()
    turn = world.dialogue.point(PointRequest(u=500, v=360))
    assert turn.target is not None
    world.grounding.error = error  # type: ignore[assignment]
    refused = confirm(world, turn.target.target_id)
    assert (refused.ok, refused.retryable) == (False, True)
    assert "could not look" in refused.reply
    assert str(error) in refused.reply
    assert not world.controller.goals
    world.grounding.error = None
    assert confirm(world, turn.target.target_id).ok


class Lenient(World):
    """A dialogue that goes where nobody looked."""

    unchecked: UncheckedVeto = "allow"


def test_an_operator_may_configure_to_go_unchecked_and_is_told() -> None:
    world = Lenient()
    turn = world.dialogue.point(PointRequest(u=500, v=360))
    assert turn.target is not None
    world.grounding.error = UnavailableError("nobody serves it")
    done = confirm(world, turn.target.target_id)
    assert done.ok
    assert "did not look" in done.reply


def test_without_a_list_nobody_is_asked() -> None:
    known = KnownThings(book=BOOK)
    watch = Watch(known.find, (), patience_s=1.0)
    guard = Guard(watch, (), share=0.3, margin=0.05, unchecked="refuse")
    world = World(**first_words())
    world.say(FIRST)
    shown = world.dialogue.shown()
    assert shown is not None
    assert guard.verdict(shown) == Verdict()
    assert not known.watched


# --- looks at pictures


def test_a_picture_is_looked_at_once() -> None:
    known = KnownThings(person=BOOK)
    known.words = {"glass"}
    watch = Watch(known.find, ("person", "glass"), patience_s=1.0)
    assert watch.look(FRAME) == watch.look(FRAME)
    assert known.watched == [(7, ("person", "glass"))]


def test_a_failed_look_is_made_again() -> None:
    known = KnownThings(person=BOOK)
    watch = Watch(known.find, ("person",), patience_s=1.0)
    known.error = DeadlineError("no reply within 5 s")
    with pytest.raises(DeadlineError):
        watch.look(FRAME)
    known.error = None
    assert watch.look(FRAME).evidence["person"].found


def test_another_model_is_asked_for_every_phrase_again() -> None:
    """A restarted grounding may know the words that the one before did not."""
    known = KnownThings(glass=BOOK)
    watch = Watch(known.find, ("person", "glass"), patience_s=1.0)
    assert watch.look(FRAME).unknown == {"person": ("person",)}
    known.model, known.words = "larger", {"person"}
    again = watch.look(Frame(8, 1280, 720, b"next"))
    assert again.unknown == {}
    assert set(again.evidence) == {"person", "glass"}
    assert watch.model == "larger"


def test_a_model_that_knows_none_of_the_words_is_still_met_again() -> None:
    known = KnownThings()
    watch = Watch(known.find, ("person", "flame"), patience_s=1.0)
    assert watch.look(FRAME).evidence == {}
    known.model, known.words = "larger", {"person", "flame"}
    assert set(watch.look(Frame(8, 1280, 720, b"next")).evidence) == {"person", "flame"}


def test_an_answer_about_other_phrases_is_no_answer() -> None:
    def short(frame: Frame, phrases: Sequence[str]) -> GroundingReply:
        return GroundingReply(model="x", width=1, height=1, evidence=[], milliseconds=0.0)

    with pytest.raises(RemoteError, match="asked about 1"):
        Watch(short, ("person",), patience_s=1.0).look(FRAME)


def test_who_asks_meanwhile_waits_for_the_running_look_but_not_for_ever() -> None:
    known = KnownThings(person=BOOK)
    asked, go_on = threading.Event(), threading.Event()

    def slow(frame: Frame, phrases: Sequence[str]) -> GroundingReply:
        asked.set()
        go_on.wait(10.0)
        return known.find(frame, phrases)

    watch = Watch(slow, ("person",), patience_s=0.02)
    thread = threading.Thread(target=watch.look, args=(FRAME,))
    thread.start()
    asked.wait(10.0)
    with pytest.raises(DeadlineError, match=r"within 0\.02 s"):
        watch.look(FRAME)
    go_on.set()
    thread.join(10.0)
    assert watch.look(FRAME).evidence["person"].found
    assert len(known.watched) == 1


# --- words


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("the person's arm", ("person",)),
        ("persons", ("person",)),
        ("a human's left hand", ("human hand",)),
        ("the personal computer", ()),
        ("my right hand", ()),
        ("", ()),
    ],
)
def test_words_name_a_phrase_when_they_hold_all_of_its_words(
    text: str, expected: tuple[str, ...]
) -> None:
    assert named_in(text, VETOED) == expected


@given(st.text(max_size=200))
def test_any_text_can_be_searched_for_names(text: str) -> None:
    named = named_in(text, VETOED)
    assert set(named) <= set(VETOED)
    assert set(named_in(f"{text} of a person", VETOED)) >= {*named, "person"}


@pytest.mark.parametrize("phrase", ["", "...", "x" * 101, "the"])
def test_a_phrase_nobody_can_look_for_is_refused_at_the_start(phrase: str) -> None:
    with pytest.raises(ConfigError, match="--veto"):
        check_phrases([phrase])


def test_phrases_are_counted_once_and_bounded() -> None:
    assert check_phrases(["dog", "dog", "cat"]) == ("dog", "cat")
    with pytest.raises(ConfigError, match="33 phrases"):
        check_phrases([f"thing {i}" for i in range(33)])


def test_a_phrase_of_the_operator_has_a_reason_too() -> None:
    assert fragility("glass") == "glass: may break under my weight"
    assert fragility("greenhouse") == "greenhouse: may not bear my weight"
