"""The scripted operator: looks, says something, watches what comes of it, and learns.

Knows the picture with the dot and the ring, what was said, and what the robot replied; nothing of
pixels, boxes or models.
"""

from collections import Counter
from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from w2c.messages import Turn
from w2c_evaluation.corrections.correcting import Beliefs, corrections
from w2c_evaluation.corrections.eye import RING_PX, Eye, Look, Pixel, distance
from w2c_evaluation.corrections.instructing import Speaking, instructions
from w2c_evaluation.corrections.saying import Chooser, Saying
from w2c_evaluation.corrections.voice import Voice
from w2c_evaluation.scenarios.answering import NEW_PLACE, Wish, choose_option, read_question

WILLING = 0.35
"""How much of what the best words would gain may be left undone by choosing others"""
FAR_PX = 100.0
"""From a dot farther off people may name the place anew rather than correct"""
AS_EXPECTED = 0.8
"""Cosine between the move that was seen and the expected one, from which on it says how far words
go"""
ELSEWHERE = 0.3
"""Below this cosine the words meant something else to the robot"""
MOST_FAILURES = 2
"""Times that a meaning is tried in other words"""
DROPS = 0.5
"""How often a question that cannot be answered is dropped, where nothing is lost by that"""


@dataclass(frozen=True)
class Seen:
    """What came of words."""

    reply: str
    ok: bool
    dot: Pixel | None
    """That is shown now"""


class Operator:
    """One person, who remembers from picture to picture how far words go."""

    def __init__(self, voice: Voice, rng: np.random.Generator, *, corrects: bool) -> None:
        """Begin.

        Args:
            voice: How it talks.
            rng: Of everything that is drawn.
            corrects: Knows that a point can be corrected (phase 2 of the study).
        """
        self._voice = voice
        self._chooser = Chooser(rng)
        self._eye = Eye(rng)
        self._rng = rng
        self._corrects = corrects
        self._beliefs = Beliefs(rng)
        self.begin()

    def begin(self) -> None:
        """Turn to another picture."""
        self._last: Pixel | None = None
        self._unknown: frozenset[str] = frozenset()
        self._failed: set[str] = set()
        self._failures: Counter[str] = Counter()
        self._done_with: set[str] = set()
        self._led_to: dict[str, tuple[Saying, Pixel]] = {}

    def speak(self, look: Look) -> Saying | None:
        """Return what to say to a picture; None: content, or at a loss for better words."""
        if look.inside:
            return None
        now = float("inf") if look.dot is None else hypot(*self._eye.offset(look.dot, look.ring))
        sayings = [one for one in self._all(look, now) if self._may_say(one)]
        sayings += [] if self._corrects else self._again(look)
        best = min((one.leaves for one in sayings), default=now)
        if best >= now:
            return None
        # Without a dot there is nothing to gain on: what is about as good as the best will do.
        limit = max(2.0 * best, RING_PX) if look.dot is None else best + WILLING * (now - best)
        willing = [one for one in sayings if one.leaves <= limit]
        return willing[int(self._rng.integers(len(willing)))]

    def hear(self, saying: Saying, before: Pixel | None, seen: Seen) -> None:
        """Take in what came of words.

        Args:
            saying: What was said.
            before: The dot then; None = there was none.
            seen: What came of it.
        """
        if not seen.ok or seen.dot is None:
            self._failed.add(saying.text)
            self._failures[saying.meaning] += 1
            if saying.name and f"'{saying.name}'" in seen.reply:
                self._unknown |= {saying.name}
            return
        if not saying.changes or before is None:
            self._last = None
            self._done_with.add(saying.meaning)
            self._led_to[saying.meaning] = saying, seen.dot
            return
        move = seen.dot[0] - before[0], seen.dot[1] - before[1]
        meant = saying.lands[0] - before[0], saying.lands[1] - before[1]
        along = _cosine(move, meant)
        if saying.belief and along >= AS_EXPECTED:
            self._beliefs.learn(saying.belief, hypot(*meant), self._eye.length(hypot(*move)))
        if saying.name or along < ELSEWHERE:
            self._done_with.add(saying.meaning)
        self._last = None if saying.kind == "back" else move

    def answer(self, turn: Turn, saying: Saying) -> str | None:
        """Return the answer to a question; None: none of its options fits.

        Args:
            turn: That asks.
            saying: What it asks about.
        """
        question = read_question(turn)
        if question is None:
            return None
        thing = saying.thing
        wish = Wish(
            centre=saying.lands if thing is None else thing.centre,
            reach=60.0 if thing is None else 0.5 * distance(thing.at(0, 0), thing.at(1, 1)),
            changes=saying.changes,
        )
        option = choose_option(question, wish)
        if option is None or NEW_PLACE in question.options:
            return option
        return self._chooser.pick(self._voice.words.answer).format(option=option)

    def drop(self, look: Look) -> str | None:
        """Return words that drop a question, where that drops nothing else; None: others."""
        if look.dot is None and self._chooser.chance(DROPS):
            return self._chooser.pick(self._voice.words.cancel)
        return None

    def _all(self, look: Look, now: float) -> list[Saying]:
        """Return everything that could be said, once a meaning."""
        speaking = Speaking(self._voice, look, self._eye, self._chooser, self._unknown)
        if look.dot is None or not self._corrects:
            return list(instructions(speaking))
        sayings = list(corrections(speaking, self._beliefs, look.dot, self._last))
        return sayings + (list(instructions(speaking)) if now > FAR_PX else [])

    def _again(self, look: Look) -> list[Saying]:
        """Return the instructions that were said, each with where the dot was then."""
        return [
            replace(saying, lands=dot, leaves=hypot(*self._eye.offset(dot, look.ring)))
            for saying, dot in self._led_to.values()
            if dot != look.dot
        ]

    def _may_say(self, saying: Saying) -> bool:
        tired = self._failures[saying.meaning] >= MOST_FAILURES
        return (
            saying.text not in self._failed and saying.meaning not in self._done_with and not tired
        )


def _cosine(one: Pixel, other: Pixel) -> float:
    """Return the cosine of the angle between two moves; -1 where one of them is none."""
    length = hypot(*one) * hypot(*other)
    return (one[0] * other[0] + one[1] * other[1]) / length if length > 0.0 else -1.0
