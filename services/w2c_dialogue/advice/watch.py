"""One look at each picture for all phrases that are watched for."""

import logging
import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from w2c.errors import CallError, DeadlineError, RemoteError
from w2c.messages import GroundingReply, PhraseEvidence
from w2c_dialogue.interfaces import Frame

log = logging.getLogger("w2c.dialogue")

KEPT_LOOKS = 8
"""Pictures whose answers are kept: a correction mostly speaks about one of the last"""

Find = Callable[[Frame, Sequence[str]], GroundingReply]
"""Looks for phrases in a picture, with heatmaps. Raises CallError."""


@dataclass(frozen=True)
class Seen:
    """What one picture shows of the phrases."""

    evidence: dict[str, PhraseEvidence]
    """Of the phrases that the model knows"""
    unknown: dict[str, tuple[str, ...]]
    """Phrases with words that the model does not know, and those words"""

    def of(self, phrases: Sequence[str]) -> list[PhraseEvidence]:
        """Return the evidence for those of the phrases that were looked for."""
        return [self.evidence[phrase] for phrase in phrases if phrase in self.evidence]


@dataclass
class _Look:
    done: threading.Event = field(default_factory=threading.Event)
    seen: Seen | None = None
    error: CallError | None = None


class Watch:
    """Asks grounding once a picture. Thread-safe; who asks while another does waits for it.

    Phrases with words that the model has never seen are left out of the next looks: its answer for
    them means nothing, and takes its time. Another model is asked for all of them again.
    """

    def __init__(self, find: Find, phrases: Sequence[str], patience_s: float) -> None:
        """Prepare.

        Args:
            find: Looks at a picture; has a deadline of its own.
            phrases: What is watched for.
            patience_s: How long to wait for the look of another thread [s].
        """
        self._find = find
        self._phrases = tuple(phrases)
        self._patience_s = patience_s
        self._lock = threading.Lock()
        self._looks: OrderedDict[tuple[int, int], _Look] = OrderedDict()
        self._model = ""
        self._unknown: dict[str, tuple[str, ...]] = {}

    @property
    def model(self) -> str:
        """Name of the model that answered last; "" = none has."""
        return self._model

    @property
    def unknown(self) -> dict[str, tuple[str, ...]]:
        """Return the phrases that this model cannot look for, each with the words it lacks."""
        return dict(self._unknown)

    def look(self, frame: Frame) -> Seen:
        """Return what a picture shows of the phrases. Raises CallError."""
        key = (frame.stamp_ns, hash(frame.jpeg))
        with self._lock:
            look = self._looks.get(key)
            mine = look is None
            if look is None:
                look = self._looks[key] = _Look()
                while len(self._looks) > KEPT_LOOKS:
                    self._looks.popitem(last=False)
        if mine:
            self._work(look, frame, key)
        elif not look.done.wait(self._patience_s):
            raise DeadlineError(f"grounding gave no answer within {self._patience_s:g} s")
        if look.seen is None:
            raise look.error or RemoteError("the look at the picture was given up")
        return look.seen

    def _work(self, look: _Look, frame: Frame, key: tuple[int, int]) -> None:
        try:
            look.seen = self._ask(frame)
        except CallError as error:
            look.error = error
        finally:
            if look.seen is None:
                with self._lock:  # the next one who wants to know asks again
                    self._looks.pop(key, None)
            look.done.set()

    def _ask(self, frame: Frame) -> Seen:
        if not self._phrases:
            return Seen({}, {})
        known = [phrase for phrase in self._phrases if phrase not in self._unknown]
        # Where nothing is left to look for, one phrase still tells whether the model is another.
        asked = known or list(self._phrases[:1])
        reply = self._reply(frame, asked)
        if reply.model != self._model and len(asked) < len(self._phrases):
            asked = list(self._phrases)
            reply = self._reply(frame, asked)
        if reply.model != self._model:
            self._meet(reply)
        evidence = {
            phrase: seen
            for phrase, seen in zip(asked, reply.evidence, strict=True)
            if not seen.unknown_words
        }
        unheard = {
            seen.phrase: tuple(seen.unknown_words) for seen in reply.evidence if seen.unknown_words
        }
        return Seen(evidence, self._unknown | unheard)

    def _reply(self, frame: Frame, phrases: list[str]) -> GroundingReply:
        reply = self._find(frame, phrases)
        if len(reply.evidence) != len(phrases):
            raise RemoteError(
                f"grounding was asked about {len(phrases)} phrases and told about "
                f"{len(reply.evidence)}"
            )
        return reply

    def _meet(self, reply: GroundingReply) -> None:
        """Remember what a model that answers for the first time does not know, and say it once."""
        unknown = {
            phrase: tuple(seen.unknown_words)
            for phrase, seen in zip(self._phrases, reply.evidence, strict=True)
            if seen.unknown_words
        }
        self._model, self._unknown = reply.model, unknown
        if unknown:
            log.warning(
                "the vision model does not know all phrases that are watched for: not looked for",
                extra={"model": reply.model, "phrases": ", ".join(unknown)},
            )
