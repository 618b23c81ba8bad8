"""Recorded calls: who asked whom for what, what came of it, and how long it took."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgspec

from w2c import messages as m
from w2c import topics
from w2c.bus import Input
from w2c_recorder.reading import Recorded, decode_payload, method_of

MOST_PHRASES = 4
"""Told one by one; of more only those that were found"""


@dataclass(frozen=True)
class Call:
    """One call, as its caller saw it."""

    end_ns: int
    """Arrival of its trace at the recorder [ns since 1970]"""
    caller: str
    service: str
    method: str
    outcome: str
    """ok, or the code of the error"""
    duration_ms: float
    error: str
    request: m.Message | None
    """None where it does not decode. A picture to be looked at is left out"""
    reply: m.Message | None
    """None where none came, or it does not decode; an ErrorReply where the call was refused"""
    source: Input | None
    """Reference to the request: `inputs` of what was made of it hold the same"""
    inputs: list[Input]
    """What the request was made of"""

    @property
    def name(self) -> str:
        """As in the registry: service/method."""
        return f"{self.service}/{self.method}"


def call_of(recorded: Recorded, trace: m.CallTrace) -> Call:
    """Return a call from its trace. What does not decode is missing."""
    method = method_of(trace)
    request_type, reply_type = (None, None) if method is None else (method.request, method.reply)
    envelope, request, _ = decode_payload(trace.request, request_type)
    reply = decode_payload(trace.reply, reply_type if trace.outcome == "ok" else m.ErrorReply)[1]
    if isinstance(request, m.GroundingRequest):  # the camera's channel holds the same picture
        request = msgspec.structs.replace(request, jpeg=b"")
    source = None
    if envelope is not None:
        key = f"w2c/{topics.VERSION}/{envelope.robot}/rpc/{trace.service}"
        key = f"{key}/{trace.instance}/{trace.method}"
        source = Input(key=key, boot_id=envelope.boot_id, sequence=envelope.sequence)
    return Call(
        end_ns=recorded.log_time_ns,
        caller="" if recorded.envelope is None else recorded.envelope.sender,
        service=trace.service,
        method=trace.method,
        outcome=trace.outcome,
        duration_ms=trace.duration_ms,
        error=trace.error,
        request=request,
        reply=reply,
        source=source,
        inputs=[] if envelope is None else list(envelope.inputs),
    )


def describe_call(call: Call) -> str:
    """Return a call in one line: what was asked, what came, and how long it took."""
    if call.outcome != "ok":
        return (
            f"call {call.name} failed after {call.duration_ms:.0f} ms: {call.outcome}: {call.error}"
        )
    told = _TELL.get(type(call.reply))
    answer = told(call.reply) if told else ""
    return f"call {call.name}, {call.duration_ms:.0f} ms{': ' if answer else ''}{answer}"


def point_text(point: m.Array) -> str:
    """Return a point of the world (3,) for people [m]."""
    return f"({point[0]:.3f}, {point[1]:.3f}, {point[2]:.3f}) m"


def evidence_text(evidence: m.PhraseEvidence) -> str:
    """Return what was found for a phrase."""
    if evidence.point is None:
        return f"'{evidence.phrase}' not found"
    u, v = evidence.point
    return f"'{evidence.phrase}' at ({u:.0f}, {v:.0f}), score {evidence.score:.2f}"


def _grounding(reply: m.GroundingReply) -> str:
    evidence = reply.evidence
    if len(evidence) <= MOST_PHRASES:
        return "; ".join(evidence_text(one) for one in evidence)
    found = [one for one in evidence if one.found]
    told = "".join(f"; {evidence_text(one)}" for one in found[:MOST_PHRASES])
    return f"{len(found)} of {len(evidence)} phrases found{told}"


def _choice(reply: m.ChooseReply) -> str:
    return f"{reply.option}, probability {reply.probabilities.get(reply.option, 0.0):.2f}"


def _lift(reply: m.LiftReply) -> str:
    warning = f"; {reply.warning}" if reply.warning else ""
    return f"{point_text(reply.point)}, within {reply.error_bound * 1e3:.0f} mm{warning}"


def _preview(reply: m.PreviewReply) -> str:
    verdict = "reachable" if reply.reachable else f"{reply.distance * 100:.1f} cm too far"
    return f"{verdict}; {reply.reason}" if reply.reason else verdict


_TELL: dict[type[m.Message] | type[None], Callable[[Any], str]] = {
    m.ChooseReply: _choice,
    m.CompleteReply: lambda reply: reply.text,
    m.GroundingReply: _grounding,
    m.LiftReply: _lift,
    m.PreviewReply: _preview,
    m.GoalReply: lambda reply: f"{reply.goal_id} from tick {reply.start_tick}",
    m.StopReply: lambda reply: reply.mode,
    m.ResumeReply: lambda reply: reply.text,
}
