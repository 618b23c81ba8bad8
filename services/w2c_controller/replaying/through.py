"""`w2c replay FILE --through controller`: the recorded commands, made again tick by tick.

The controller is the one of this version, from its first tick where the recording has it, or from
the first snapshot. It is told what the recorded one was told, at the ticks that the recording
names, and all that it gives is compared: every command, and its snapshots, goal events, safety
events and status. Where a stretch cannot be made again, or a command differs, it goes on from the
next snapshot.
"""

import re
from collections.abc import Iterator, Sequence
from typing import Any

from msgspec.structs import replace

from w2c import topics
from w2c.bus.codec import decode_message, encode_message
from w2c.difference import INFINITE, Difference, differences
from w2c.errors import ControlError
from w2c.messages import ControllerSnapshot, Message, RobotState
from w2c.through import Compared, Heard, Session, Skipped
from w2c_controller.loop.reports import goal_message, safety_message, status_message
from w2c_controller.loop.summary import Snapshot
from w2c_controller.replaying.given import ROWS, Given, read_given
from w2c_controller.replaying.player import Done, LostError, Player, Silence
from w2c_controller.replaying.ticks import Pairing, Tick
from w2c_controller.safety.hazards import SafetyReport
from w2c_controller.snapshots.state_tree import SnapshotError

TOLERANCE = 1e-9
"""Of every number, in its unit. On the machine and the versions that recorded it is equal bit by
bit; other processors may round sums otherwise."""
TIMES = ("lateness_us", "tick_us")
"""What a status says of the machine, not of the robot"""
COMMAND, SNAPSHOT, GOAL, SAFETY, STATUS = (
    f"{row.kind}/{row.service}/{row.name}" for row in (topics.JOINT_COMMAND, *ROWS)
)
NOT_BEGUN = "up to the first snapshot, of a controller that began before the recording"


def through(session: Session, tolerance: float | None) -> Iterator[Compared | Skipped]:
    """Make the recorded commands again. See `w2c.through.Through`."""
    given = read_given(session)
    run = Run(given, TOLERANCE if tolerance is None else tolerance)
    pairing = Pairing()
    for heard in session.heard(topics.ROBOT_STATE, topics.JOINT_COMMAND):
        for tick in pairing.add(heard):
            yield from run.step(tick)
    for tick in pairing.finish():
        yield from run.step(tick)


class Run:
    """Goes through the ticks of a recording, of one controller process after the other."""

    def __init__(self, given: Given, tolerance: float) -> None:
        self._given = given
        self._tolerance = tolerance
        self._boot_id = ""
        """Of the controller"""
        self._robot = ""
        """Boot id"""
        self._player: Player | None = None
        """None where it waits for a snapshot"""
        self._reason = NOT_BEGUN
        """Why it waits"""

    def step(self, tick: Tick) -> Iterator[Compared | Skipped]:
        """Do what led to one command, and compare."""
        envelope = tick.command.envelope
        if envelope.boot_id != self._boot_id:
            self._boot_id, self._player, self._reason = envelope.boot_id, None, NOT_BEGUN
            self._robot = tick.states[-1].envelope.boot_id if tick.states else ""
            if envelope.sequence == 0 and tick.states:
                self._player = self._new_player()
                tick_before = tick.states[-1].message.tick
                previous = self._given.before(self._boot_id, self._robot, tick_before)
                self._player.begin(previous)
        if tick.states and tick.states[-1].envelope.boot_id != self._robot:
            self._player = None
            self._reason = "the robot began anew while the controller ran on"
        if tick.problem:
            self._player, self._reason = None, tick.problem
        if self._player is None:
            yield from self._wait(tick)
            return
        yield from self._do(self._player, tick)

    def _new_player(self) -> Player:
        return Player(self._given, self._boot_id, self._robot)

    def _wait(self, tick: Tick) -> Iterator[Compared | Skipped]:
        """Go on from the snapshot of this tick, where there is one."""
        kept = self._given.snapshots.get((self._boot_id, tick.command.message.tick))
        if not tick.states or kept is None or kept.robot != tick.states[-1].envelope.boot_id:
            yield Skipped(COMMAND, tick.command.seconds, self._reason)
            return
        player, state = self._new_player(), tick.states[-1]
        try:
            player.go_on(kept.read(), state.message)
            silences = player.rest(state.message)
        except (SnapshotError, LostError) as error:
            self._reason = f"no snapshot after it can be gone on from: {error}"
            silences = []
        else:
            self._player = player
        yield Skipped(COMMAND, tick.command.seconds, self._reason)
        for silence in silences:
            yield from self._compare_silence(silence, state)

    def _do(self, player: Player, tick: Tick) -> Iterator[Compared | Skipped]:
        """Tick, and compare what came of it."""
        for state in tick.states:
            last = state is tick.states[-1]
            try:
                done = player.tick(state)
            except LostError as error:
                self._player, self._reason = None, str(error)
                yield from self._wait(tick)
                return
            except ControlError as error:
                self._player, self._reason = None, f"after tick {state.message.tick} failed"
                found = (Difference("", "a command", str(error), INFINITE),)
                yield self._compared(COMMAND, tick.command, found, state, [])
                return
            if last:
                yield from self._compare_command(tick.command, done, state)
            yield from self._compare_told(player, done, state)
            try:
                silences = player.rest(state.message)
            except LostError as error:
                self._player, self._reason = None, str(error)
                return
            for silence in silences:
                yield from self._compare_silence(silence, state)

    def _compare_command(self, command: Heard, done: Done, state: Heard) -> Iterator[Compared]:
        joints = self._given.description(self._robot).joints
        found = tuple(
            _with_joint(one, [joint.name for joint in joints])
            for one in differences(command.message, done.command)
        )
        compared = self._compared(COMMAND, command, found, state, done.told)
        if compared.differs():
            self._player = None
            self._reason = f"after the command of tick {state.message.tick}, which differs"
        yield compared

    def _compare_told(self, player: Player, done: Done, state: Heard) -> Iterator[Compared]:
        """Compare what else was told of this tick."""
        message: RobotState = state.message
        stamp_ns, told = message.stamp_ns, done.told
        goals = [goal_message(event, stamp_ns) for event in done.events]
        recorded = self._given.goals.get((self._boot_id, stamp_ns), [])
        yield from self._compare_lists(GOAL, recorded, goals, state, told)
        yield from self._compare_hazards(done.reports, stamp_ns, state, told)
        yield from self._compare_status(player.controller.snapshot(), "", stamp_ns, state, told)
        kept = self._given.snapshots.get((self._boot_id, message.tick))
        if kept is not None:
            found = tuple(_snapshot_differences(kept.read(), player))
            yield Compared(
                SNAPSHOT, f"tick {kept.tick}", kept.seconds, found, self._tolerance,
                _inputs(state, told) if found else (),
            )  # fmt: skip

    def _compare_silence(self, silence: Silence, state: Heard) -> Iterator[Compared]:
        """Compare what was told while no state came; `state` is the last that had come."""
        stamp_ns, told = silence.stamp_ns, silence.told
        yield from self._compare_hazards(silence.reports, stamp_ns, state, told)
        yield from self._compare_status(silence.snapshot, silence.trouble, stamp_ns, state, told)

    def _compare_hazards(
        self, reports: Sequence[SafetyReport], stamp_ns: int, state: Heard, told: list[str]
    ) -> Iterator[Compared]:
        recorded = self._given.hazards.get((self._boot_id, stamp_ns), [])
        made = [safety_message(report, stamp_ns) for report in reports]
        yield from self._compare_lists(SAFETY, recorded, made, state, told)

    def _compare_status(
        self, snapshot: Snapshot, trouble: str, stamp_ns: int, state: Heard, told: list[str]
    ) -> Iterator[Compared]:
        status = self._given.statuses.get((self._boot_id, stamp_ns))
        if status is not None:
            made = status_message(snapshot, {}, {}, trouble, stamp_ns)
            found = tuple(differences(status.message, made, TIMES))
            yield self._compared(STATUS, status, found, state, told)

    def _compare_lists(
        self,
        stream: str,
        recorded: Sequence[Heard],
        made: Sequence[Message],
        state: Heard,
        told: list[str],
    ) -> Iterator[Compared]:
        """Compare what was told with what is told now, in order."""
        for heard, message in zip(recorded, made, strict=False):
            found = tuple(differences(heard.message, message))
            yield self._compared(stream, heard, found, state, told)
        for heard in recorded[len(made) :]:
            missing = (Difference("", heard.message, "nothing", INFINITE),)
            yield self._compared(stream, heard, missing, state, told)
        for message in made[len(recorded) :]:
            extra = (Difference("", "nothing", message, INFINITE),)
            yield self._compared(stream, state, extra, state, told)

    def _compared(
        self,
        stream: str,
        recorded: Heard,
        found: tuple[Difference, ...],
        state: Heard,
        told: list[str],
    ) -> Compared:
        return Compared(
            stream,
            f"tick {state.message.tick}",
            recorded.seconds,
            found,
            self._tolerance,
            _inputs(state, told) if found else (),
        )


def _snapshot_differences(recorded: ControllerSnapshot, player: Player) -> Iterator[Difference]:
    """Yield in what the controller is not as the recorded one was after this tick."""
    controller = player.controller
    made = ControllerSnapshot(
        stamp_ns=recorded.stamp_ns,
        tick=recorded.tick,
        reason=recorded.reason,
        robot_boot_id=recorded.robot_boot_id,
        controller_boot_id=recorded.controller_boot_id,
        phase=controller.phase,
        in_contact=controller.retargeting.state.enabled,
        command=controller.command,
        state=controller.export(),
    )
    # As it comes from the bus, where a number of the model's libraries is a number like all others.
    made = decode_message(encode_message(made), ControllerSnapshot)
    return differences(
        replace(recorded, state=_in_order(recorded.state)),
        replace(made, state=_in_order(made.state)),
    )


def _in_order(tree: Any) -> Any:
    """Return a captured tree with what is in its sets in order: a set has none of its own."""
    if isinstance(tree, list):
        return [_in_order(item) for item in tree]
    if not isinstance(tree, dict):
        return tree
    inner = {name: _in_order(item) for name, item in tree.items()}
    if inner.get("@") == "set":
        inner["items"] = sorted(inner["items"], key=repr)
    return inner


def _with_joint(difference: Difference, names: Sequence[str]) -> Difference:
    """Return a difference of a command with the name of its joint."""
    match = re.fullmatch(r"position\[(\d+)\]", difference.path)
    if match is None:
        return difference
    path = f"{difference.path} {names[int(match[1])]}"
    return Difference(path, difference.first, difference.second, difference.size)


def _inputs(state: Heard, told: list[str]) -> list[str]:
    """Return for people what a tick was made of."""
    message: RobotState = state.message
    lines = [
        f"state of tick {message.tick}, robot time {message.stamp_ns * 1e-9:.3f} s, "
        f"robot {message.mode}, number {state.envelope.sequence} of its process",
    ]
    for name in ("position", "command", "torque", "sole_wrenches", "left_wrist_wrench"):
        numbers = ", ".join(f"{value:.4g}" for value in getattr(message, name).ravel())
        lines.append(f"  {name}: {numbers}")
    return [*lines, *told]
