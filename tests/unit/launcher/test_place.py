"""`w2c place --point`: nothing goes to a place that the dialogue's veto list forbids."""

import pytest

from w2c import topics
from w2c.bus import CallContext, InProcessHub
from w2c.errors import RefusedError
from w2c.messages import GoalReply, PlaceGoal, VetoReply, VetoRequest
from w2c_launcher.placing import PlaceConfig, place_point

TO_THE_TABLE = PlaceConfig(end_effector="right_hand", point=(0.6, -0.2, 0.8))
UNASKED = PlaceConfig(end_effector="right_hand", point=(0.6, -0.2, 0.8), veto=False)


class Host:
    """A controller that takes every goal, and a dialogue that says what a test wants, or none."""

    def __init__(self, reply: VetoReply | None) -> None:
        hub = InProcessHub()
        self.reply = reply
        self.goals: list[PlaceGoal] = []
        self.asked: list[VetoRequest] = []
        self.operator = hub.connect("operator")
        hub.connect("controller").serve(topics.PLACE, self._place)
        if reply is not None:
            hub.connect("dialogue").serve(topics.VETO, self._veto)

    def _place(self, goal: PlaceGoal, _: CallContext) -> GoalReply:
        self.goals.append(goal)
        return GoalReply(goal_id=goal.goal_id, start_tick=0)

    def _veto(self, request: VetoRequest, _: CallContext) -> VetoReply:
        self.asked.append(request)
        assert self.reply is not None
        return self.reply


def test_a_point_that_nothing_forbids_is_gone_to() -> None:
    host = Host(VetoReply())
    assert place_point(host.operator, TO_THE_TABLE) == (host.goals[0].goal_id, "")
    assert host.asked[0].point.tolist() == [0.6, -0.2, 0.8]


def test_a_vetoed_point_is_refused_with_its_reason_and_nothing_moves() -> None:
    host = Host(VetoReply(refusal="I see 'person' at the target."))
    with pytest.raises(RefusedError, match=r"'person' at the target\. --no-veto goes there"):
        place_point(host.operator, TO_THE_TABLE)
    assert host.goals == []


def test_without_a_dialogue_nothing_moves_unless_told_so() -> None:
    host = Host(None)
    with pytest.raises(RefusedError, match="nobody looked for what must not be touched"):
        place_point(host.operator, TO_THE_TABLE)
    assert host.goals == []
    place_point(host.operator, UNASKED)
    assert len(host.goals) == 1


def test_no_veto_asks_nobody_and_what_was_not_looked_at_is_said() -> None:
    host = Host(VetoReply(note="The point is not in the picture."))
    place_point(host.operator, UNASKED)
    assert host.asked == []
    assert "not in the picture" in place_point(host.operator, TO_THE_TABLE)[1]
    assert len(host.goals) == 2
