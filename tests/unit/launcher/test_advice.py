"""Advice in the terminal."""

import pytest

from w2c import topics
from w2c.bus import InProcessHub
from w2c.messages import Advice, AdviceCheck, Remark, Unchecked
from w2c_launcher.advice import follow_advice, lines_of

GLASS = Remark(
    kind="material",
    level="caution",
    text="looks like glass: may break under my weight",
    source="grounding",
    value=0.54321,
    limit=0.17,
)
REACH = Remark(kind="reach", level="fine", text="my right hand can lean there", source="controller")
VETO = Remark(
    kind="veto", level="veto", text="I see 'person'", source="grounding", value=0.9, limit=0.3
)


def advice(target_id: str = "t-1", pending: list[AdviceCheck] | None = None) -> Advice:
    return Advice(
        stamp_ns=1,
        target_id=target_id,
        frame_stamp_ns=1,
        remarks=[REACH, GLASS, VETO],
        unchecked=[Unchecked(check="veto", reason="does not know 'flame'")],
        pending=pending or [],
        seconds=0.1,
    )


def test_what_forbids_comes_first_and_what_is_unknown_last() -> None:
    assert lines_of(advice()) == [
        "veto: I see 'person'",
        "caution: looks like glass: may break under my weight (0.54, limit 0.17)",
        "fine: my right hand can lean there",
        "not checked: veto: does not know 'flame'",
    ]


def test_the_last_word_on_the_own_target_is_shown() -> None:
    hub = InProcessHub()
    told = hub.connect("operator").queue(topics.ADVICE)
    dialogue = hub.connect("dialogue")
    for message in (advice("t-0"), advice(pending=["reach"]), advice()):
        dialogue.publish(topics.ADVICE, message)
    assert follow_advice(told, "t-1", 5.0) == lines_of(advice())


@pytest.mark.parametrize("heard", [True, False])
def test_patience_ends(heard: bool) -> None:
    hub = InProcessHub()
    told = hub.connect("operator").queue(topics.ADVICE)
    if heard:
        hub.connect("dialogue").publish(topics.ADVICE, advice(pending=["reach"]))
    last = follow_advice(told, "t-1", 0.05)[-1]
    assert last.startswith("not checked yet: reach" if heard else "advice: none within 0.05 s")
