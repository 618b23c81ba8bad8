"""The verbs of the operator: `say`, `confirm`, `place`, `release`, `stop`, `resume`."""

import sys
import time
import uuid
from typing import Annotated

import msgspec

from w2c import topics
from w2c.bus import Bus, Queue
from w2c.bus.zenoh_bus import connect
from w2c.config import ServiceConfig, parse
from w2c.errors import BusError, CallError, ConfigError, ConnectionFailedError
from w2c.messages import (
    ConfirmRequest,
    Empty,
    EndEffector,
    GoalEvent,
    PointRequest,
    ReleaseGoal,
    SayRequest,
    StopRequest,
    Target,
    Turn,
)
from w2c.system import Connection, service_config
from w2c_launcher.advice import follow_advice
from w2c_launcher.placing import PlaceConfig, place_point
from w2c_launcher.turn_text import turn_lines

FINAL_STATES = {"loaded", "reached", "unreachable", "released", "aborted"}
GOOD_STATES = {"loaded", "reached", "released"}


class SayConfig(Connection, frozen=True, kw_only=True):
    """Say something to the robot."""

    text: str
    """What to say."""
    wait: Annotated[float, msgspec.Meta(ge=0)] = 90.0
    """How long to wait for a motion that the words start [s]; 0 = do not wait."""
    advice: Annotated[float, msgspec.Meta(ge=0)] = 3.0
    """How long to wait for advice on the target that the words propose [s]; 0 = do not wait."""


def say(arguments: list[str] | None = None) -> int:
    """Say something; prints what was understood. `w2c say "put your hand on the book"`."""
    words, flags = _split_words(arguments or [])
    if not words and "--text" not in flags and "--help" not in flags and "-h" not in flags:
        raise ConfigError('nothing said; example: w2c say "place your right hand on the book"')
    text = ["--text", " ".join(words)] if words else []
    config = parse(SayConfig, [*flags, *text], program="w2c say")
    with _connect(config) as bus:
        events = bus.queue(topics.GOAL_EVENT)
        told = bus.queue(topics.ADVICE)
        target_id = _current_target(bus.latest(topics.TARGET).wait(1.2))
        turn = bus.call(topics.SAY, SayRequest(text=config.text, target_id=target_id)).message
        status = _finish(turn, events, config.wait)
        if turn.target is not None and turn.target.state == "proposed" and config.advice > 0:
            print("\n".join(follow_advice(told, turn.target.target_id, config.advice)))
        return status


def _current_target(received: object) -> str:
    """Return the id of the proposed target that the dialogue last published."""
    message = getattr(received, "message", None)
    if isinstance(message, Target) and message.state == "proposed":
        return message.target_id
    return ""


class ConfirmConfig(Connection, frozen=True, kw_only=True):
    """Confirm the target: the robot goes there."""

    target: str = ""
    """Id of the target; empty = the one that is proposed now."""
    wait: Annotated[float, msgspec.Meta(ge=0)] = 90.0
    """How long to wait for the motion [s]; 0 = do not wait."""


def confirm(arguments: list[str] | None = None) -> int:
    """Confirm the proposed target."""
    config = parse(ConfirmConfig, arguments or [], program="w2c confirm")
    with _connect(config) as bus:
        target_id = config.target or _current_target(bus.latest(topics.TARGET).wait(1.5))
        if not target_id:
            print('there is no target to confirm; propose one first: w2c say "..."')
            return 1
        events = bus.queue(topics.GOAL_EVENT)
        turn = bus.call(topics.CONFIRM, ConfirmRequest(target_id=target_id)).message
        return _finish(turn, events, config.wait)


def place(arguments: list[str] | None = None) -> int:
    """Place an end effector. Exit status 0 when it got there."""
    config = parse(PlaceConfig, arguments or [], program="w2c place")
    if (config.point is None) == (config.pixel is None):
        raise ConfigError("give either --point X Y Z or --pixel U V")
    if config.pixel is not None and config.force > 0.0:
        raise ConfigError("--force goes with --point X Y Z, not with --pixel")
    with _connect(config) as bus:
        events = bus.queue(topics.GOAL_EVENT)
        if config.pixel is not None:
            goal_id = _place_pixel(bus, config, config.pixel)
        else:
            goal_id, note = place_point(bus, config)
            if note:
                print(note)
        return _follow(events, goal_id, config.wait)


def _place_pixel(bus: Bus, config: PlaceConfig, pixel: tuple[float, float]) -> str:
    request = PointRequest(
        u=pixel[0], v=pixel[1], end_effector=config.end_effector, task=config.task
    )
    turn = bus.call(topics.POINT, request).message
    _print_turn(turn)
    if not turn.ok or turn.target is None:
        return ""
    confirmed = bus.call(topics.CONFIRM, ConfirmRequest(target_id=turn.target.target_id)).message
    _print_turn(confirmed)
    return confirmed.goal_id if confirmed.ok else ""


class ReleaseConfig(Connection, frozen=True, kw_only=True):
    """Take a hand off its support and bring it back, or lift a foot."""

    end_effector: EndEffector
    """Which one."""
    wait: Annotated[float, msgspec.Meta(ge=0)] = 60.0
    """How long to wait for the end [s]."""


def release(arguments: list[str] | None = None) -> int:
    """Release a hand, or lift a foot. Exit status 0 when it is free."""
    config = parse(ReleaseConfig, arguments or [], program="w2c release")
    with _connect(config) as bus:
        events = bus.queue(topics.GOAL_EVENT)
        goal = ReleaseGoal(
            goal_id=f"release-{uuid.uuid4().hex[:8]}", end_effector=config.end_effector
        )
        return _follow(events, bus.call(topics.RELEASE, goal).message.goal_id, config.wait)


class StopConfig(Connection, frozen=True, kw_only=True):
    """Make the robot hold, whatever else lives or is dead."""

    reason: str = "operator"
    """Goes into the recording."""


def stop(arguments: list[str] | None = None) -> int:
    """Hold: asks the robot's own endpoint first, then the router. Exit status 0 = acknowledged."""
    config = parse(StopConfig, arguments or [], program="w2c stop")
    service = service_config(config)
    problems = []
    for endpoint in (service.robot_endpoint, service.router):
        try:
            with connect(service, "operator", [endpoint]) as bus:
                reply = bus.call(topics.ROBOT_STOP, StopRequest(reason=config.reason)).message
        except (ConnectionFailedError, CallError) as error:
            problems.append(f"{endpoint}: {error}")
            continue
        print(f"acknowledged: the robot is {reply.mode}; go on with: w2c resume")
        return 0
    sys.stderr.write("STOP NOT DELIVERED. " + "; ".join(problems) + "\n")
    return 1


class ResumeConfig(Connection, frozen=True, kw_only=True):
    """Let the robot move again, after a stop or where the controller holds and asks."""


def resume(arguments: list[str] | None = None) -> int:
    """End a stop, and what else the controller holds for. Exit status 1 = it still holds."""
    config = parse(ResumeConfig, arguments or [], program="w2c resume")
    with _connect(config) as bus:
        return end_holds(bus)


def end_holds(bus: Bus) -> int:
    """Tell robot and controller to go on, and print what they say. Returns the exit status."""
    print(f"the robot is {bus.call(topics.ROBOT_RESUME, Empty()).message.mode}")
    try:
        reply = bus.call(topics.CONTROLLER_RESUME, Empty()).message
    except CallError as error:
        sys.stderr.write(f"the controller does not answer: {error}\n")
        return 0
    if reply.holding:
        sys.stderr.write(f"the controller still holds: {reply.text}\n")
    return 1 if reply.holding else 0


def _connect(config: Connection) -> "_OperatorBus":
    service = service_config(config)
    return _OperatorBus(service)


class _OperatorBus:
    """A connection whose errors name what to do."""

    def __init__(self, service: ServiceConfig) -> None:
        self._bus = connect(service, "operator", [service.router])

    def __enter__(self) -> Bus:
        return self._bus

    def __exit__(self, *_: object) -> None:
        self._bus.close()


def _finish(turn: Turn, events: Queue[GoalEvent], patience_s: float) -> int:
    """Print a turn, and what becomes of the motion that it started. Returns the exit status."""
    _print_turn(turn)
    if not turn.ok:
        return 1
    return _follow(events, turn.goal_id, patience_s) if turn.goal_id else 0


def _follow(events: Queue[GoalEvent], goal_id: str, patience_s: float) -> int:
    """Print what becomes of a goal until it ends. Returns the exit status."""
    if not goal_id:
        return 1
    deadline = time.monotonic() + patience_s
    while (remaining := deadline - time.monotonic()) > 0:
        received = events.receive(remaining)
        if received is None or received.message.goal_id != goal_id:
            continue
        event = received.message
        distance = f" ({event.distance * 1e3:.0f} mm left)" if event.distance >= 0 else ""
        print(f"{event.end_effector}: {event.state}{distance} {event.reason}".rstrip())
        if event.state in FINAL_STATES:
            return 0 if event.state in GOOD_STATES else 1
    if patience_s > 0:
        raise BusError(f"goal {goal_id} did not end within {patience_s:.0f} s; see: w2c status")
    print(f"goal {goal_id} accepted")
    return 0


def _print_turn(turn: Turn) -> None:
    print("\n".join(turn_lines(turn)))


def _split_words(arguments: list[str]) -> tuple[list[str], list[str]]:
    """Split leading words from the flags that follow."""
    for at, argument in enumerate(arguments):
        if argument.startswith("-"):
            return arguments[:at], arguments[at:]
    return arguments, []
