"""From a joint command back to the words it came from: what each step was computed from.

A message names what it was computed from (`inputs`); a goal, a target and a tick name each other by
their ids. Each step says which of the two led to it.
"""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from w2c import messages as m
from w2c import topics
from w2c.bus import Input
from w2c.errors import RecordingError
from w2c_recorder.calls import Call, describe_call, evidence_text, point_text
from w2c_recorder.history import LATE_S, History, Timed, latest
from w2c_recorder.reading import Recorded, Recording

STATES_KEPT = 2000
"""Before the instant in question: 4 s of them"""
QUESTIONS = ("llm", "grounding", "perception")
MOST_CORRECTIONS = 100
"""A chain of targets that goes round in a damaged recording must end"""


@dataclass(frozen=True)
class Step:
    """One link of the chain."""

    seconds: float
    """When it reached the recorder, in the time of the timeline [s]"""
    what: str
    """command, state, phase, goal, request, confirmation, target, words, call, heatmap or frame"""
    text: str
    link: str
    """How it was found: `inputs`, or the id that leads to it"""


@dataclass(frozen=True)
class Motion:
    """The command in question and the state that it answers."""

    command: Recorded
    state: Recorded | None


def motion_at(recording: Recording, at_ns: int) -> Motion:
    """Read a recording for the command in force at a time. Raises RecordingError: there is none."""
    command: Recorded | None = None
    states: deque[Recorded] = deque(maxlen=STATES_KEPT)
    for recorded in recording.messages(decode=False):
        if recorded.log_time_ns > at_ns:
            # Not at another key: who comes and goes is written at once, before what is queued.
            if recorded.topic is topics.JOINT_COMMAND:
                break
        elif recorded.topic is topics.JOINT_COMMAND:
            command = recorded
        elif recorded.topic is topics.ROBOT_STATE:
            states.append(recorded)
    if command is None:
        raise RecordingError(
            f"no joint command was recorded before {(at_ns - recording.start_ns) * 1e-9:.3f} s"
        )
    command = command.decoded()
    if not isinstance(command.message, m.JointCommand):
        raise RecordingError(f"the joint command cannot be read: {command.problem}")
    return Motion(command, _answered(command, states))


def _answered(command: Recorded, states: deque[Recorded]) -> Recorded | None:
    """Return the state that a command was computed from."""
    envelope = command.envelope
    inputs = [] if envelope is None else envelope.inputs
    numbers = {given.sequence & 0xFFFF_FFFF for given in inputs if given.key.endswith("/joints")}
    for state in reversed(states):
        if numbers and state.sequence not in numbers:
            continue
        found = state.decoded()
        if found.envelope is None:
            continue
        source = Input(found.key, found.envelope.boot_id, found.envelope.sequence)
        same_tick = (
            isinstance(found.message, m.RobotState)
            and isinstance(command.message, m.JointCommand)
            and found.message.tick == command.message.tick
        )
        if source in inputs or (not inputs and same_tick):
            return found
    return None


def explain(history: History, motion: Motion) -> Iterator[Step]:
    """Yield the chain from a command back to the words, as far as the recording tells it."""
    at_ns = motion.command.log_time_ns
    yield from _command(history, motion)
    status = latest(history.statuses, at_ns)
    goal_id = "" if status is None else status.message.goal_id
    if status is not None:
        text = status.message.phase + (f" towards {goal_id}" if goal_id else ", no goal under way")
        yield Step(history.seconds(status.at_ns), "phase", text, "newest before the command")
    event = _event(history, goal_id, at_ns)
    if event is None:
        yield Step(history.seconds(at_ns), "goal", "none was set before: the robot stands", "none")
        return
    yield _goal_step(history, event, "goal_id of the phase" if goal_id else "last goal before")
    place = _place(history, event.message.goal_id)
    if place is not None:
        yield _request_step(history, place)
    confirmation = _confirmation(history, event.message.goal_id)
    if confirmation is None or confirmation.message.target is None:
        who = "an unknown process" if place is None else place.caller
        yield Step(
            history.seconds(event.at_ns),
            "confirmation",
            f"none: {who} set the goal without a conversation",
            "goal_id",
        )
        return
    yield _words(history, confirmation, "confirmation", "goal_id")
    yield from _target(history, confirmation.message.target, confirmation.at_ns)


def _command(history: History, motion: Motion) -> Iterator[Step]:
    command, state = motion.command, motion.state
    tick = command.message.tick if isinstance(command.message, m.JointCommand) else -1
    seconds = history.seconds(command.log_time_ns)
    yield Step(seconds, "command", f"joint command of tick {tick}", "newest at that time")
    if state is None or not isinstance(state.message, m.RobotState):
        yield Step(seconds, "state", f"of tick {tick}: not in the recording", "tick")
        return
    age_ms = (command.publish_time_ns - state.publish_time_ns) * 1e-6
    linked = command.envelope is not None and bool(command.envelope.inputs)
    yield Step(
        history.seconds(state.log_time_ns),
        "state",
        f"of tick {tick}, robot {state.message.mode}; the command left {age_ms:.1f} ms after it",
        "inputs" if linked else "tick",
    )


def _event(history: History, goal_id: str, at_ns: int) -> Timed[m.GoalEvent] | None:
    """Return the newest news of a goal; of the last one before where none is under way."""
    events = [one for one in history.events if goal_id in ("", one.message.goal_id)]
    return latest(events, at_ns)


def _goal_step(history: History, event: Timed[m.GoalEvent], link: str) -> Step:
    goal = event.message
    reason = f": {goal.reason}" if goal.reason else ""
    accepted = [
        one
        for one in history.events
        if one.message.goal_id == goal.goal_id and one.message.state == "accepted"
    ]
    since = f", accepted at {history.seconds(accepted[0].at_ns):.3f} s" if accepted else ""
    text = f"{goal.goal_id}: {goal.end_effector} {goal.task}, {goal.state}{reason}{since}"
    return Step(history.seconds(event.at_ns), "goal", text, link)


def _place(history: History, goal_id: str) -> Call | None:
    for call in history.calls:
        named = isinstance(call.request, m.PlaceGoal | m.ReleaseGoal)
        if named and call.method != "preview" and getattr(call.request, "goal_id", "") == goal_id:
            return call
    return None


def _request_step(history: History, call: Call) -> Step:
    goal = call.request
    where = f" to {point_text(goal.point)}" if isinstance(goal, m.PlaceGoal) else ""
    text = f"{call.caller} asked for it{where}; {describe_call(call)}"
    return Step(history.seconds(call.end_ns), "request", text, "goal_id")


def _confirmation(history: History, goal_id: str) -> Timed[m.Turn] | None:
    for turn in history.turns:
        if turn.message.goal_id == goal_id and turn.message.target is not None:
            return turn
    return None


def _words(history: History, turn: Timed[m.Turn], what: str, link: str) -> Step:
    """Return a turn with who asked for it."""
    cause = history.call_by(turn.inputs)
    who = "somebody" if cause is None else cause.caller
    said = f'said "{turn.message.text}"' if turn.message.text else "pressed or pointed"
    if cause is not None and isinstance(cause.request, m.PointRequest):
        said = f"pointed at ({cause.request.u:.0f}, {cause.request.v:.0f})"
    elif cause is not None and isinstance(cause.request, m.ConfirmRequest):
        said = f"confirmed {cause.request.target_id}"
    through = "" if cause is None else f" through {cause.name} [inputs]"
    text = f"{who} {said}{through}; {turn.message.module}: {turn.message.reply}"
    return Step(history.seconds(turn.at_ns), what, text, link)


def _target(history: History, target: m.Target, at_ns: int) -> Iterator[Step]:
    """Yield a target, the words that moved it, and those that first named it."""
    seen: set[str] = set()
    link = "target of the confirmation"
    while target.target_id not in seen and len(seen) < MOST_CORRECTIONS:
        seen.add(target.target_id)
        proposal = history.proposal_of(target.target_id)
        if proposal is None or proposal.message.target is None:
            yield Step(
                history.seconds(at_ns),
                "target",
                f"{target.target_id}: the turn that proposed it is not in the recording",
                "target_id",
            )
            return
        target = proposal.message.target
        yield _target_step(history, proposal, target, link)
        yield _words(history, proposal, "words", "target_id")
        yield from _questions(history, proposal)
        yield from _frame(history, target, proposal.at_ns)
        before = _corrected(history, proposal)
        if before is None:
            return
        target, link = before, "target_id of the words"


def _target_step(history: History, turn: Timed[m.Turn], target: m.Target, link: str) -> Step:
    where = "" if target.point is None else f" = {point_text(target.point)}"
    boxes = "".join(
        f"; box of '{phrase}' [{box.left:.0f} {box.top:.0f} {box.right:.0f} {box.bottom:.0f}]"
        for phrase, box in zip(target.phrases, target.boxes, strict=False)
    )
    warning = f"; {target.warning}" if target.warning else ""
    text = (
        f"{target.target_id} at ({target.u:.1f}, {target.v:.1f}){where}, "
        f"correction {target.corrections}{boxes}{warning}"
    )
    return Step(history.seconds(turn.at_ns), "target", text, link)


def _questions(history: History, turn: Timed[m.Turn]) -> Iterator[Step]:
    """Yield what the models and perception were asked for this turn, newest first."""
    late_ns = round(LATE_S * 1e9)
    start_ns = turn.at_ns - round(turn.message.seconds * 1e9) - late_ns
    evidence = None if turn.message.target is None else history.evidence_of(turn.message.target)
    target = turn.message.target
    for call in reversed(history.calls):
        if call.caller != turn.sender or call.service not in QUESTIONS:
            continue
        began_ns = call.end_ns - round(call.duration_ms * 1e6)
        during = start_ns <= began_ns <= turn.at_ns and call.end_ns <= turn.at_ns + late_ns
        if call is evidence and isinstance(call.reply, m.GroundingReply):
            found = "; ".join(evidence_text(one) for one in call.reply.evidence)
            text = f"{call.reply.model}: {found}, {call.duration_ms:.0f} ms"
            yield Step(history.seconds(call.end_ns), "heatmap", text, "phrases and frame")
        elif during and _concerns(call, target):
            yield Step(
                history.seconds(call.end_ns), "call", describe_call(call), "time of the turn"
            )


def _concerns(call: Call, target: m.Target | None) -> bool:
    """Tell whether a question belongs to a turn: what is looked up beside it is left out."""
    if isinstance(call.request, m.LiftRequest) and target is not None:
        return (call.request.u, call.request.v) == (target.u, target.v)
    return call.service == "llm"


def _frame(history: History, target: m.Target, at_ns: int) -> Iterator[Step]:
    frame = history.frame_of(target, at_ns)
    stamp = f"picture of robot time {target.frame_stamp_ns * 1e-9:.3f} s"
    if frame is None:
        yield Step(history.seconds(at_ns), "frame", f"{stamp}: not in the recording", "frame stamp")
        return
    evidence = history.evidence_of(target)
    linked = evidence is not None and frame.source in evidence.inputs
    yield Step(
        history.seconds(frame.at_ns),
        "frame",
        f"{stamp}, number {frame.source.sequence} of the camera",
        "inputs" if linked else "frame stamp",
    )


def _corrected(history: History, turn: Timed[m.Turn]) -> m.Target | None:
    """Return the target that the words of a turn moved; None for one that was named anew."""
    target = turn.message.target
    if target is None or target.corrections == 0:
        return None
    cause = history.call_by(turn.inputs)
    named = cause.request.target_id if cause and isinstance(cause.request, m.SayRequest) else ""
    before = history.proposal_of(named) if named else None
    if before is None:
        earlier = [one for one in history.turns if one.message.target is not None]
        before = latest(earlier, turn.at_ns - 1)
    return None if before is None else before.message.target
