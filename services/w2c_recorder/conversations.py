"""The conversations of a recording: an instruction, its corrections, the yes, and how it ended."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from w2c import messages as m
from w2c_recorder.history import History, Timed

PREDICTION = "prediction."
CORRECTION = "correction"
CONFIRMATION = "confirmation"
POINTED = "point"
QUESTION = "question"


@dataclass
class Conversation:
    """What was said about one place, from the first words to the end of the motion."""

    turns: list[Timed[m.Turn]]
    """That showed a target: the instruction or click, then the corrections"""
    failed: list[Timed[m.Turn]] = field(default_factory=list)
    """That changed nothing"""
    confirmation: Timed[m.Turn] | None = None
    events: list[Timed[m.GoalEvent]] = field(default_factory=list)
    """Of its goal"""

    asked: dict[int, str] = field(default_factory=dict)
    """Number of a turn that answered a question -> the words that the question was about"""

    def words(self, turn: Timed[m.Turn]) -> str:
        """Return the words that a turn took up: those before a question, where it answered one."""
        return self.asked.get(turn.source.sequence, turn.message.text)

    @property
    def confirmed(self) -> m.Target | None:
        """The target that the person said yes to; None where there was none."""
        return None if self.confirmation is None else self.confirmation.message.target

    @property
    def outcome(self) -> str:
        """How it ended: the last state of its goal, or why there was none."""
        if self.events:
            return self.events[-1].message.state
        return "not confirmed" if self.confirmation is None else "confirmed"

    @property
    def reason(self) -> str:
        """Why it ended so, as the controller said."""
        return self.events[-1].message.reason if self.events else ""

    def shows(self, target_id: str) -> bool:
        """Tell whether the present target of this conversation is that one."""
        target = self.turns[-1].message.target
        return target is not None and target.target_id == target_id


def conversations_of(history: History) -> Iterator[Conversation]:
    """Yield the conversations in the order of their first words."""
    found: list[Conversation] = []
    words = ""
    for turn in history.turns:
        if turn.message.module == QUESTION:
            words = words or turn.message.text
            continue
        _sort_in(found, turn)
        if words and turn.message.ok and found:
            found[-1].asked[turn.source.sequence] = words
        words = ""
    for event in history.events:
        for conversation in found:
            confirmation = conversation.confirmation
            goal_id = "" if confirmation is None else confirmation.message.goal_id
            if goal_id and goal_id == event.message.goal_id:
                conversation.events.append(event)
    yield from found


def _sort_in(found: list[Conversation], turn: Timed[m.Turn]) -> None:
    """Give a turn to its conversation, or begin one with it."""
    message = turn.message
    target = message.target
    present = found[-1] if found else None
    if message.ok and target is not None:
        if message.module.startswith(PREDICTION) or message.module == POINTED:
            found.append(Conversation([turn]))
        elif message.module == CORRECTION and present is not None:
            present.turns.append(turn)
        elif message.module == CONFIRMATION:
            for conversation in reversed(found):
                if conversation.shows(target.target_id) and conversation.confirmation is None:
                    conversation.confirmation = turn
                    break
    elif not message.ok and message.text and present is not None and not present.confirmation:
        present.failed.append(turn)
