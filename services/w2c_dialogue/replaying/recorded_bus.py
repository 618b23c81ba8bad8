"""A bus on which the other services say what they said in a recording."""

import time
from collections import defaultdict, deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

import msgspec

from w2c.bus import Envelope, InProcessBus, InProcessHub, Input, Received
from w2c.bus.codec import ENVELOPE_VERSION, encode_message
from w2c.bus.interface import CallContext
from w2c.errors import (
    CallError,
    DeadlineError,
    RefusedError,
    RemoteError,
    UnavailableError,
)
from w2c.messages import ChooseRequest, CompleteRequest, ErrorReply, Message, Turn
from w2c.through import Asked
from w2c.topics import Method, Topic

Request = TypeVar("Request", bound=Message)
Reply = TypeVar("Reply", bound=Message)
M = TypeVar("M", bound=Message)

_ERRORS: dict[str, type[CallError]] = {
    error.code: error for error in (DeadlineError, RefusedError, RemoteError, UnavailableError)
}


class RecordedBus(InProcessBus):
    """Answers what was asked before, in the order in which it was answered; remembers turns.

    The same question again gets the last of its answers.
    """

    def __init__(self, robot: str, boot_id: str, asked: Sequence[Asked]) -> None:
        """Learn what was answered.

        Args:
            robot: Its name on the keys.
            boot_id: Of the recorded process: ids of targets and goals begin with it.
            asked: The calls that it made.
        """
        super().__init__(InProcessHub(), robot, "dialogue", "0")
        self.boot_id = boot_id
        self.turns: list[tuple[Turn, Sequence[Input]]] = []
        """Published since they were last taken, with what caused them"""
        self.unknown: list[str] = []
        """What was asked and is not in the recording, in words"""
        self.answered: Callable[[Asked], None] = lambda _asked: None
        """Called with each answer before it is given"""
        self._answers: dict[tuple[str, bytes], deque[Asked]] = defaultdict(deque)
        for call in asked:
            if call.request is not None:
                self._answers[_key(call.service, call.method, call.request)].append(call)

    def publish(self, topic: Topic[M], message: M, inputs: Sequence[Input] = ()) -> Input:
        """Remember turns; all else is for nobody."""
        if isinstance(message, Turn):
            self.turns.append((message, tuple(inputs)))
        return Input(key=topic.key(self.robot), boot_id=self.boot_id, sequence=0)

    def call(
        self,
        method: Method[Request, Reply],
        request: Request,
        *,
        timeout_s: float | None = None,  # noqa: ARG002 - it was answered, or was not
        inputs: Sequence[Input] = (),  # noqa: ARG002 - nobody reads them
        instance: str | None = None,  # noqa: ARG002 - one answered
    ) -> Received[Reply]:
        """Return what was answered then.

        Raises:
            CallError: as it was raised then; UnavailableError where this was not asked.
        """
        answers = self._answers.get(_key(method.service, method.name, request))
        if not answers:
            what = f"{method.service}/{method.name}: {_short(request)}"
            self.unknown.append(what)
            raise UnavailableError(f"this was not asked in the recording: {what}")
        asked = answers.popleft() if len(answers) > 1 else answers[0]
        self.answered(asked)
        if asked.outcome != "ok" or not isinstance(asked.reply, method.reply):
            text = asked.reply.message if isinstance(asked.reply, ErrorReply) else asked.error
            raise _ERRORS.get(asked.outcome, RemoteError)(text)
        return received(asked.reply, "", asked.replier_boot_id, 0, method.service, self.robot)

    def take_turns(self) -> Iterator[tuple[Turn, Sequence[Input]]]:
        """Yield the turns since the last look."""
        turns, self.turns = self.turns, []
        yield from turns


def received(
    message: M, key: str, boot_id: str, sequence: int, sender: str, robot: str
) -> Received[M]:
    """Return a message as a bus gives it."""
    envelope = Envelope(
        version=ENVELOPE_VERSION,
        robot=robot,
        sender=sender,
        boot_id=boot_id,
        sequence=sequence,
        monotonic_ns=0,
        clock_ns=0,
        inputs=[],
        data=None,
    )
    return Received(message, key, envelope, time.monotonic_ns())


def context_of(asked: Asked, robot: str) -> CallContext:
    """Return the context of a recorded call, as its handler had it."""
    source = asked.source or Input(key="", boot_id="", sequence=-1)
    request: Received[Any] = received(
        asked.request, source.key, source.boot_id, source.sequence, asked.caller, robot
    )
    return CallContext(caller=asked.caller, request=request)


def _key(service: str, method: str, request: Message) -> tuple[str, bytes]:
    """Return what makes a question what it is; how long its answer may take does not."""
    if isinstance(request, CompleteRequest | ChooseRequest):
        request = msgspec.structs.replace(request, deadline=None)
    return f"{service}/{method}", encode_message(request)


def _short(request: Message) -> str:
    """Return a request for people, without its bytes."""
    names = (name for name in request.__struct_fields__ if name != "jpeg")
    values = {name: getattr(request, name) for name in names}
    text = msgspec.json.encode(values, enc_hook=repr).decode()
    return text if len(text) <= 300 else f"{text[:150]} ... {text[-150:]}"
