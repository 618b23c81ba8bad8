"""`w2c replay FILE --through dialogue`: the recorded turns, made again from the recorded answers.

The other services say what they said. Words, clicks, confirmations and news of goals come in the
order in which the recorded process took them: turns one after the other, and what happens to a goal
while a turn is taken after it. What the process found by its own clock (a goal or a robot that fell
silent) is taken as it was told. Advice, which is made beside the turns, is not compared.
"""

from collections import deque
from collections.abc import Iterator, Sequence
from typing import Any

from w2c import topics
from w2c.bus import Input, Received
from w2c.clock import StepClock
from w2c.difference import INFINITE, Difference, differences
from w2c.errors import CallError, ModelError
from w2c.messages import (
    AllowedAreaRequest,
    ConfirmRequest,
    HeightFieldRequest,
    PointRequest,
    SayRequest,
    Turn,
)
from w2c.through import Asked, Compared, Heard, Session, Skipped, configuration
from w2c_dialogue.config import DialogueConfig
from w2c_dialogue.node import DialogueNode
from w2c_dialogue.replaying.recorded_bus import RecordedBus, context_of

TOLERANCE = 1e-9
"""Of every number, in its unit; on the machine that recorded it is equal bit by bit"""
TURN = "event/dialogue/turn"
TIMES = ("stamp_ns", "seconds", "steps")
"""What a turn says of the machine"""
ASKED = ("llm", "grounding", "perception", "controller", "robot")
ROWS = (topics.CAMERA_FRAME, topics.CAMERA_VIEW, topics.GOAL_EVENT, topics.TURN)
PICTURES = (topics.CAMERA_FRAME, topics.CAMERA_VIEW)
REMEMBERED = 40
"""Pictures and poses that a process which began anew may have got before it was spoken to"""
LIMB = "effector"
"""Task of a question that advice asks, too: an instruction is heard once"""
LOOKS = HeightFieldRequest | AllowedAreaRequest
Work = SayRequest | ConfirmRequest | PointRequest


def through(session: Session, tolerance: float | None) -> Iterator[Compared | Skipped]:
    """Make the recorded turns again. See `w2c.through.Through`."""
    answers = [asked for asked in session.asked(*ASKED) if asked.caller == "dialogue"]
    said = sorted(session.asked("dialogue"), key=lambda asked: asked.began_s)
    told = list(session.heard(topics.TURN))
    limit = TOLERANCE if tolerance is None else tolerance
    config = configuration(session, "dialogue", DialogueConfig)
    yield from Run(config, session.heard(*ROWS), answers, said, told, limit).play()


class Run:
    """Goes through a conversation, of one dialogue process after the other."""

    def __init__(
        self,
        config: DialogueConfig,
        source: Iterator[Heard],
        answers: Sequence[Asked],
        said: Sequence[Asked],
        told: Sequence[Heard],
        tolerance: float,
    ) -> None:
        self._config = config
        self._source = source
        self._next = next(source, None)
        self._later: deque[Heard] = deque()
        """Read and not yet taken: what came while a turn was taken"""
        self._answers = answers
        looks = [asked for asked in answers if isinstance(asked.request, LOOKS)]
        self._looks = deque(sorted(looks, key=lambda asked: asked.began_s))
        """Questions about the newest picture, in the order in which they were asked"""
        self._waiting = deque(asked for asked in said if isinstance(asked.request, Work))
        self._told = deque(told)
        self._tolerance = tolerance
        self._bus: RecordedBus | None = None
        self._node: DialogueNode | None = None
        self._turn: Asked | None = None
        """That is taken, or was taken last"""
        self._clock = StepClock(1)
        self._seen: set[int] = set()
        """Stamps of the pictures whose camera pose is known too"""
        self._pictures: deque[Heard] = deque(maxlen=REMEMBERED)
        self._events: deque[Heard] = deque()
        """That came while a turn was taken"""
        self._made: deque[tuple[Turn, Sequence[Input]]] = deque()

    def play(self) -> Iterator[Compared | Skipped]:
        """Take all messages."""
        while self._later or self._next is not None:
            if self._later:
                heard = self._later.popleft()
                yield from self._say_until(heard.seconds)
                yield from self._hear(heard)
                continue
            first = self._next
            yield from self._begin(first)
            if first is not None and first is self._next and not self._later:
                self._next = next(self._source, None)
                yield from self._hear(first)
        yield from self._finish()

    def _begin(self, first: Heard | None) -> Iterator[Compared | Skipped]:
        """Take the turns that had begun when a message arrived."""
        if first is None:
            return
        if self._node is None and self._told:
            self._become(self._told[0].envelope.boot_id, first.envelope.robot)
        yield from self._say_until(first.seconds)

    def _hear(self, heard: Heard) -> Iterator[Compared | Skipped]:
        self._clock.set(max(self._clock.now_ns(), round(heard.seconds * 1e9)))
        if heard.topic in PICTURES:
            self._take_picture(heard)
        elif heard.topic is topics.GOAL_EVENT:
            self._events.append(heard)
            self._follow()
        elif not heard.envelope.inputs:
            node = self._become(heard.envelope.boot_id, heard.envelope.robot)
            self._lose(node, heard.message)
        yield from self._compare()

    def _finish(self) -> Iterator[Compared | Skipped]:
        """Do what is left, and tell of the turns that were not made."""
        yield from self._say_until(float("inf"))
        self._follow()
        yield from self._compare()
        for heard in self._told:
            yield Skipped(TURN, heard.seconds, "nothing in the recording caused it")

    def _become(self, boot_id: str, robot: str) -> DialogueNode:
        """Go on as the process of a boot id, which may be another one."""
        if self._node is not None and self._bus is not None and self._bus.boot_id == boot_id:
            return self._node
        self._bus = RecordedBus(robot, boot_id, self._answers)
        self._bus.answered = self._on_answer
        self._node = DialogueNode(self._config, self._bus, self._clock)
        for heard in self._pictures:
            self._look(self._node, heard)
        return self._node

    def _take_picture(self, heard: Heard) -> None:
        self._pictures.append(heard)
        if self._node is not None:
            self._look(self._node, heard)

    def _look(self, node: DialogueNode, heard: Heard) -> None:
        if heard.topic is topics.CAMERA_FRAME:
            node.on_frame(_received(heard))
        else:
            node.on_view(_received(heard))
            self._seen.add(heard.message.stamp_ns)

    # --- turns -----------------------------------------------------------------------------------
    def _say_until(self, seconds: float) -> Iterator[Compared | Skipped]:
        """Take the turns that had begun at a time, and whose picture is there."""
        while self._waiting and self._waiting[0].began_s < seconds:
            asked = self._waiting[0]
            stamp_ns = getattr(asked.request, "frame_stamp_ns", -1)
            if stamp_ns >= 0 and stamp_ns not in self._seen and asked.seconds > seconds:
                return  # the recorded process waited for it, too
            self._waiting.popleft()
            self._say(asked)
            self._follow()
            yield from self._compare()

    def _say(self, asked: Asked) -> None:
        request = asked.request
        if asked.outcome != "ok" or self._bus is None:
            return
        node = self._become(asked.replier_boot_id, self._bus.robot)
        context = context_of(asked, self._bus.robot)
        self._turn = asked
        self._catch_up(asked.began_s)
        self._take_advice(node, asked)
        if isinstance(request, SayRequest):
            node.say(request, context)
        elif isinstance(request, ConfirmRequest):
            node.confirm(request, context)
        elif isinstance(request, PointRequest):
            node.point(request, context)

    def _take_advice(self, node: DialogueNode, asked: Asked) -> None:
        """Find out what advice had found out before a yes, so that the turn need not ask."""
        told = self._told_of((asked.source,) if asked.source is not None else ())
        if told is None or told.message.module != "confirmation":
            return
        evidence = told.message.evidence
        if evidence is not None and any(one.task == LIMB for one in evidence.answers):
            return  # it was the turn that asked
        try:
            node.hear_limb()
        except (CallError, ModelError):
            return  # nor did advice
        finally:
            if self._bus is not None:
                self._bus.unknown.clear()

    def _told_of(self, causes: Sequence[Input]) -> Heard | None:
        """Return the recorded turn of a cause; None where it was not recorded."""
        return next((one for one in self._told if tuple(one.envelope.inputs) == causes), None)

    def _on_answer(self, asked: Asked) -> None:
        """Let time pass until a question of this turn had been answered."""
        if self._looks and self._looks[0] is asked:
            self._looks.popleft()
        self._catch_up(asked.seconds)

    def _catch_up(self, seconds: float) -> None:
        """Take the pictures that the recorded process had at this point of its turn.

        Which one was the newest is known from the question that is asked about it next.
        """
        turn = self._turn
        if turn is None:
            return
        while self._looks and self._looks[0].began_s < turn.began_s:
            self._looks.popleft()
        look = self._looks[0] if self._looks and self._looks[0].seconds <= turn.seconds else None
        newest_ns = getattr(look.request, "frame_stamp_ns", -1) if look is not None else None
        while (heard := self._next) is not None:
            picture = heard.topic in PICTURES
            if newest_ns is None and heard.seconds > seconds:
                return
            if newest_ns is not None and picture and heard.message.stamp_ns > newest_ns:
                return
            self._next = next(self._source, None)
            if picture:
                self._take_picture(heard)
            else:
                self._later.append(heard)

    def _follow(self) -> None:
        """Follow goals, unless a turn is being taken."""
        while self._events and self._node is not None:
            heard = self._events[0]
            if self._waiting and self._waiting[0].began_s < heard.seconds:
                return
            self._events.popleft()
            self._node.on_goal_event(_received(heard))

    @staticmethod
    def _lose(node: DialogueNode, turn: Turn) -> None:
        """Give up what the recorded process gave up by its own clock."""
        if turn.goal_id:
            node.give_up(turn.goal_id, turn.target.warning if turn.target else "")
        else:
            node.check_robot()

    # --- comparing -------------------------------------------------------------------------------
    def _compare(self) -> Iterator[Compared]:
        """Compare the turns that were made with those that were told, by what caused them."""
        if self._bus is None:
            return
        self._made.extend(self._bus.take_turns())
        while self._made:
            turn, inputs = self._made.popleft()
            told = self._told_of(tuple(inputs))
            if told is None:
                seconds = self._clock.now_ns() * 1e-9
                found = [Difference("", "nothing", turn, INFINITE)]
            else:
                self._told.remove(told)
                seconds = told.seconds
                found = list(differences(told.message, turn, TIMES))
            what = f"'{turn.text}'" if turn.text else turn.module
            unknown, self._bus.unknown = self._bus.unknown, []
            made_of = [
                *(f"answer to {one.key} number {one.sequence}" for one in inputs),
                *(f"asked, and not in the recording: {one}" for one in unknown),
            ]
            yield Compared(TURN, what, seconds, found, self._tolerance, made_of if found else ())


def _received(heard: Heard) -> Received[Any]:
    return Received(heard.message, heard.key, heard.envelope, 0)
