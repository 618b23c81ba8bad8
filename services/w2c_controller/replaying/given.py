"""What a recording says of all that reached a controller beside states, and of what it told."""

from collections import defaultdict
from dataclasses import dataclass, field

from w2c import topics
from w2c.bus.codec import decode_message, encode_message
from w2c.errors import RecordingError
from w2c.messages import (
    ControllerSnapshot,
    ControllerStatus,
    GoalEvent,
    GoalReply,
    PlaceGoal,
    ReleaseGoal,
    RobotDescription,
    SafetyEvent,
    StopRequest,
)
from w2c.through import Asked, Heard, Session
from w2c_controller.safety.outside import OUTSIDE

STOP_LATE_S = 5.0
"""Between a call and what the controller tells of it"""
ROWS = (
    topics.CONTROLLER_SNAPSHOT,
    topics.GOAL_EVENT,
    topics.SAFETY_EVENT,
    topics.CONTROLLER_STATUS,
)

Moment = tuple[str, int]
"""Boot id of a controller, and a tick or a stamp [ns] of its robot"""


@dataclass(frozen=True)
class Wish:
    """A goal or a release that was admitted."""

    message: PlaceGoal | ReleaseGoal
    posture_tick: int
    """The tick by whose posture it was judged; -1 = not known"""


@dataclass(frozen=True)
class Kept:
    """A snapshot, as bytes: an hour has thousands."""

    tick: int
    controller: str
    """Boot id"""
    robot: str
    """Boot id"""
    seconds: float
    payload: bytes

    def read(self) -> ControllerSnapshot:
        """Return the snapshot itself."""
        return decode_message(self.payload, ControllerSnapshot)


@dataclass
class Given:
    """All but the states, which are too many to be kept."""

    descriptions: dict[str, RobotDescription] = field(default_factory=dict)
    """Boot id of the robot -> what it is"""
    robots: dict[str, str] = field(default_factory=dict)
    """Boot id of a controller -> that of the first robot that it met"""
    wishes: dict[str, Wish] = field(default_factory=dict)
    """Id of the goal -> what was asked for"""
    stops: list[tuple[float, str]] = field(default_factory=list)
    """When somebody said stop [s of the timeline], and why"""
    snapshots: dict[Moment, Kept] = field(default_factory=dict)
    """By tick"""
    goals: dict[Moment, list[Heard]] = field(default_factory=lambda: defaultdict(list))
    """By stamp: what was told of goals"""
    hazards: dict[Moment, list[Heard]] = field(default_factory=lambda: defaultdict(list))
    """By stamp: what was told of hazards, at the state that they were told at"""
    outside: dict[Moment, dict[int, list[Heard]]] = field(default_factory=lambda: defaultdict(dict))
    """By tick, then by stamp: what the process found itself after it, and each status"""
    statuses: dict[Moment, Heard] = field(default_factory=dict)
    """By stamp: of its state, or of the silence that it tells of"""

    def description(self, robot: str) -> RobotDescription:
        """Return what a robot is. Raises RecordingError: nobody asked it while this was made."""
        if robot not in self.descriptions:
            raise RecordingError(
                f"the description of robot process '{robot}' is not in the recording: it holds no "
                "answered call of robot/describe; the recorder makes one where it finds the robot"
            )
        return self.descriptions[robot]

    def judged_at(self, tick: int) -> list[str]:
        """Return the ids of the goals that were judged by the posture of a tick."""
        return [goal_id for goal_id, wish in self.wishes.items() if wish.posture_tick == tick]

    def begun_at(self, controller: str, stamp_ns: int) -> list[str]:
        """Return the ids of the goals that a controller began at a state, in order."""
        told = self.goals.get((controller, stamp_ns), ())
        return [heard.message.goal_id for heard in told if heard.message.state == "accepted"]

    def before(self, controller: str, robot: str, tick: int) -> Kept | None:
        """Return the last snapshot of other controllers of this robot, not after a tick."""
        found = [
            kept
            for kept in self.snapshots.values()
            if kept.robot == robot and kept.tick <= tick and kept.controller != controller
        ]
        return max(found, key=lambda kept: kept.tick, default=None)

    def stop_before(self, seconds: float) -> str | None:
        """Return why somebody said stop shortly before a time; None where nobody did."""
        found = [why for at, why in self.stops if -1.0 <= seconds - at <= STOP_LATE_S]
        return found[-1] if found else None


def read_given(session: Session) -> Given:
    """Read a recording for all that reached controllers but states."""
    given = Given()
    for asked in session.asked("controller", "robot"):
        _note_call(given, asked)
    for heard in session.heard(*ROWS):
        _note_message(given, heard)
    return given


def _note_call(given: Given, asked: Asked) -> None:
    request, reply = asked.request, asked.reply
    if isinstance(reply, RobotDescription):
        given.descriptions[asked.replier_boot_id] = reply
    elif isinstance(request, PlaceGoal | ReleaseGoal) and isinstance(reply, GoalReply):
        given.wishes[request.goal_id] = Wish(request, reply.posture_tick)
    elif isinstance(request, StopRequest) and asked.service == "controller":
        given.stops.append((asked.began_s, request.reason))


def _note_message(given: Given, heard: Heard) -> None:
    message, controller = heard.message, heard.envelope.boot_id
    if not _of_first_robot(given, heard):
        return
    if isinstance(message, ControllerSnapshot):
        payload = encode_message(message)
        kept = Kept(message.tick, controller, message.robot_boot_id, heard.seconds, payload)
        given.snapshots.setdefault((controller, message.tick), kept)
    elif isinstance(message, GoalEvent):
        given.goals[controller, message.stamp_ns].append(heard)
    elif isinstance(message, SafetyEvent):
        given.hazards[controller, message.stamp_ns].append(heard)
        if message.cause in OUTSIDE and message.state == "begins":
            _note_outside(given, heard)
    elif isinstance(message, ControllerStatus):
        given.statuses.setdefault((controller, message.stamp_ns), heard)
        _note_outside(given, heard)


def _note_outside(given: Given, heard: Heard) -> None:
    message = heard.message
    told = given.outside[heard.envelope.boot_id, message.tick]
    told.setdefault(message.stamp_ns, []).append(heard)


def _of_first_robot(given: Given, heard: Heard) -> bool:
    """Tell whether a message is of the first robot that a controller met: ticks begin anew."""
    controller = heard.envelope.boot_id
    if isinstance(heard.message, ControllerSnapshot):
        robot = heard.message.robot_boot_id
    elif heard.envelope.inputs:
        robot = heard.envelope.inputs[0].boot_id
    else:
        return True
    return given.robots.setdefault(controller, robot) == robot
