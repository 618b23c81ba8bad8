"""Questions to the operator, and how the conversation goes on from an answer.

A question waits until something that was said leads on, be it its answer or something else; the
answer needs no word of what was said before. Nothing moves by an answer: it shows a target.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from w2c.messages import Box
from w2c_dialogue import which
from w2c_dialogue.outcome import Outcome
from w2c_dialogue.steps import Services
from w2c_dialogue.trail import Trail
from w2c_dialogue.utterance import Utterance

NEW_PLACE = frozenset({"another", "different", "instruction", "new", "other", "place"})
CHANGE = frozenset({"adjust", "change", "correct", "correction", "move", "same", "shift"})


@dataclass(frozen=True)
class Asked:
    """A question, what may be answered, and what follows."""

    text: str
    options: tuple[str, ...]
    read: Callable[[Utterance], int | None]
    """Returns which option an utterance chooses; None: it is no answer"""
    go_on: Callable[[int, Services], Outcome]
    """Takes up what the question was about"""
    trail: Trail
    """What was found before it was asked"""


class Asking:
    """The question that waits, at most one."""

    def __init__(self) -> None:
        self.pending: Asked | None = None

    def ask(self, asked: Asked) -> Outcome:
        """Ask, instead of any earlier question."""
        self.pending = asked
        return Outcome("question", asked.text, ok=False, options=asked.options)

    def answer(self, utterance: Utterance, services: Services) -> Outcome | None:
        """Return what follows from an answer; None: it is none.

        Raises:
            RefusedError, ModelError, CallError: as what the question was about.
        """
        asked = self.pending
        index = None if asked is None else asked.read(utterance)
        if asked is None or index is None:
            return None
        services.trail.begin_with(asked.trail)
        return asked.go_on(index, services)

    def settle(self, outcome: Outcome, before: Asked | None) -> Outcome:
        """Forget a question when the conversation went on; else say that it is still open.

        Args:
            outcome: Of a turn.
            before: What was asked before it.
        """
        if outcome.ok:
            self.pending = None
        elif before is not None and self.pending is before:
            return outcome.with_reply(f"{outcome.reply} Still open: {before.text}")
        return outcome


def which_thing(
    phrase: str,
    boxes: Sequence[Box],
    services: Services,
    go_on: Callable[[int, Services], Outcome],
) -> Asked:
    """Ask which of several things of one name is meant; `go_on` gets the index of its box."""
    names = which.names(boxes)
    every = f"{', '.join(names[:-1])} or {names[-1]}"
    return Asked(
        f"Which '{phrase}' do you mean: {every}? I see {len(boxes)} that fit.",
        names,
        lambda utterance: which.read_answer(utterance.folded, phrase, boxes),
        go_on,
        services.trail,
    )


def which_module(services: Services, go_on: Callable[[int, Services], Outcome]) -> Asked:
    """Ask whether words are a new instruction (0) or a correction (1)."""
    return Asked(
        "I am not sure: is that a new place, or a change of the target? Say 'new place' or "
        "'change'.",
        ("new place", "change"),
        _read_module,
        go_on,
        services.trail,
    )


def _read_module(utterance: Utterance) -> int | None:
    words = {word.rstrip(",") for word in utterance.folded} - which.FILLERS - {"target", "point"}
    if not words:
        return None
    return 0 if words <= NEW_PLACE else 1 if words <= CHANGE else None
