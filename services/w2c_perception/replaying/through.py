"""`w2c replay FILE --through perception`: where pictures were taken from, and what was lifted.

Perception takes a part of the states only; a view names those that it took, so that the same ones
can be taken again.
"""

from collections import deque
from collections.abc import Iterator, Sequence

from w2c import topics
from w2c.bus import Envelope
from w2c.difference import INFINITE, Difference, differences
from w2c.errors import GeometryError, RefusedError
from w2c.messages import CameraView, ControllerStatus, RobotDescription, RobotState
from w2c.through import Asked, Compared, Heard, Session, Skipped, configuration
from w2c_perception.config import PerceptionConfig
from w2c_perception.node import MOST_TICKS, STATUS_AGE_NS
from w2c_perception.replaying.known import Known
from w2c_perception.replaying.player import Player

TOLERANCE = 1e-9
"""Of every number, in its unit; on the machine that recorded it is equal bit by bit"""
VIEW = "state/perception/view"
PATIENCE = 500
"""States after the last one that a view names, before those that are missing are given up"""
MOST_KEPT = 10_000
"""States and statuses"""
ROWS = (topics.ROBOT_STATE, topics.CONTROLLER_STATUS, topics.CAMERA_FRAME, topics.CAMERA_VIEW)


def through(session: Session, tolerance: float | None) -> Iterator[Compared | Skipped]:
    """Make the recorded views and answers again. See `w2c.through.Through`."""
    descriptions = {
        asked.replier_boot_id: asked.reply
        for asked in session.asked("robot")
        if isinstance(asked.reply, RobotDescription)
    }
    calls = deque(session.asked("perception"))
    config = configuration(session, "perception", PerceptionConfig)
    run = Run(config, descriptions, TOLERANCE if tolerance is None else tolerance)
    for heard in session.heard(*ROWS):
        while calls and calls[0].seconds < heard.seconds:
            run.waiting.append(calls.popleft())
        run.hear(heard)
        yield from run.work(finish=False)
    run.waiting.extend(calls)
    yield from run.work(finish=True)


class Run:
    """Goes through views and calls in the order of the recording."""

    def __init__(
        self,
        config: PerceptionConfig,
        descriptions: dict[str, RobotDescription],
        tolerance: float,
    ) -> None:
        self._config = config
        self._descriptions = descriptions
        self._tolerance = tolerance
        self.waiting: deque[Heard | Asked] = deque()
        """Views and calls whose turn has not come"""
        self._states: dict[int, Heard] = {}
        """By tick, of the present robot"""
        self._robot = ""
        """Boot id"""
        self._newest = -1
        """Tick"""
        self._frames: dict[tuple[str, int], Heard] = {}
        """Of no view yet, by boot id and number"""
        self._statuses: deque[Heard] = deque(maxlen=MOST_KEPT)
        self._player: Player | None = None
        self._known = Known()
        self._last: Envelope | None = None
        """Of the last view"""
        self._unplaced: dict[int, str] = {}
        """Stamp of a picture [ns] -> why it is not remembered"""

    def hear(self, heard: Heard) -> None:
        """Take one message."""
        if heard.topic is topics.ROBOT_STATE:
            self._hear_state(heard)
        elif heard.topic is topics.CONTROLLER_STATUS:
            self._statuses.append(heard)
        elif heard.topic is topics.CAMERA_FRAME:
            self._frames[heard.envelope.boot_id, heard.envelope.sequence] = heard
            if len(self._frames) > 50:
                del self._frames[next(iter(self._frames))]
        else:
            self.waiting.append(heard)

    def work(self, *, finish: bool) -> Iterator[Compared | Skipped]:
        """Do what all is there for; all that waits where nothing more comes."""
        while self.waiting:
            first = self.waiting[0]
            if isinstance(first, Heard):
                if not (finish or self._is_ready(first.message)):
                    return
                yield self._view(first)
            else:
                yield self._answer(first)
            self.waiting.popleft()

    def _hear_state(self, heard: Heard) -> None:
        boot_id, tick = heard.envelope.boot_id, heard.message.tick
        if boot_id != self._robot:
            self._robot, self._player, self._newest = boot_id, None, -1
            self._states.clear()
            self._unplaced.clear()
        self._states[tick] = heard
        self._newest = max(self._newest, tick)
        if len(self._states) > MOST_KEPT:
            del self._states[next(iter(self._states))]

    def _is_ready(self, view: CameraView) -> bool:
        ticks = view.state_ticks
        if not ticks or self._newest > ticks[-1] + PATIENCE:
            return True
        return all(tick in self._states for tick in ticks)

    # --- views -----------------------------------------------------------------------------------
    def _view(self, heard: Heard) -> Compared | Skipped:
        """Take the states that a view names, and place its picture."""
        view: CameraView = heard.message
        follows = self._follows(heard)
        why_not = self._why_not(heard)
        if why_not:
            return self._skip(heard, why_not)
        player = self._take_states(view.state_ticks, follows=follows)
        frame = self._frames.pop(_source(heard), None)
        if frame is None:
            return self._skip(heard, "the picture is not in the recording")
        compared = self._compare(heard, frame, player)
        if not compared.differs():
            return compared
        stamps = (frame.message.stamp_ns, frame.message.depth_stamp_ns)
        instants = [stamp for stamp in stamps if stamp >= 0]
        why_not = self._known.why_not(instants, player.world)
        return self._skip(heard, why_not) if why_not else compared

    def _skip(self, heard: Heard, why_not: str) -> Skipped:
        self._unplaced[heard.message.stamp_ns] = why_not
        return Skipped(VIEW, heard.seconds, why_not)

    def _follows(self, heard: Heard) -> bool:
        """Return whether it is known which states perception took before those of a view."""
        envelope, last, expected = heard.envelope, self._last, 0
        if last is None or last.boot_id != envelope.boot_id:
            self._player = None
        else:
            expected = last.sequence + 1
        self._last = envelope
        return envelope.sequence == expected and len(heard.message.state_ticks) < MOST_TICKS

    def _take_states(self, ticks: Sequence[int], *, follows: bool) -> Player:
        """Take the states that a view names, all that are there, and note which are not."""
        if self._player is None:
            description = self._descriptions[self._robot]
            self._player, self._known = Player(self._config, description, self._robot), Known()
        if not follows:
            self._known.lose()
        for tick in ticks:
            if tick in self._states:
                self._take(self._player, self._states[tick])
            else:
                self._known.lose()
        last = max(ticks, default=-1)
        self._states = {tick: one for tick, one in self._states.items() if tick > last}
        return self._player

    def _compare(self, heard: Heard, frame: Heard, player: Player) -> Compared:
        view: CameraView = heard.message
        what = f"picture of {view.stamp_ns * 1e-9:.3f} s"
        try:
            made = player.place(frame.message)
        except (GeometryError, RefusedError) as error:
            self._unplaced[view.stamp_ns] = str(error)
            found = [Difference("", "a view", str(error), INFINITE)]
        else:
            found = list(differences(view, made, ("state_ticks",)))
        inputs = [
            f"picture of {view.stamp_ns} ns, number {frame.envelope.sequence} of its camera",
            f"states of ticks {', '.join(str(tick) for tick in view.state_ticks[-4:])}, and "
            f"{max(len(view.state_ticks) - 4, 0)} before them",
        ]
        return Compared(VIEW, what, heard.seconds, found, self._tolerance, inputs)

    def _why_not(self, heard: Heard) -> str:
        """Return why a view cannot be made again; "" = it can."""
        view: CameraView = heard.message
        if not view.state_ticks and self._player is None:
            return "the view does not say which states it was made of: of an older version"
        if view.robot_boot_id != self._robot:
            return "of a robot that is no more"
        if self._robot not in self._descriptions:
            return "the description of the robot is not in the recording"
        return ""

    def _take(self, player: Player, state: Heard) -> None:
        before = player.stance
        try:
            player.take(state.message, self._status_before(state.message))
        except GeometryError:
            return  # the recorded one did not take it either
        self._known.take(state.message.stamp_ns, before, player.stance)

    def _status_before(self, state: RobotState) -> Heard | None:
        """Return what the controller last said when this state came."""
        for heard in reversed(self._statuses):
            status: ControllerStatus = heard.message
            if 0 <= state.stamp_ns - status.stamp_ns <= STATUS_AGE_NS:
                return heard
        return None

    # --- calls -----------------------------------------------------------------------------------
    def _answer(self, asked: Asked) -> Compared | Skipped:
        """Answer a call again."""
        stream = f"{asked.service}/{asked.method}"
        stamp_ns = getattr(asked.request, "frame_stamp_ns", -1)
        if asked.request is None or asked.outcome not in ("ok", "refused"):
            return Skipped(stream, asked.seconds, f"it was not answered then: {asked.outcome}")
        if self._player is None or stamp_ns in self._unplaced:
            why = self._unplaced.get(stamp_ns, "no picture before it could be placed")
            return Skipped(stream, asked.seconds, why)
        refused = asked.outcome == "refused"
        try:
            made = self._player.answer(asked)
        except RefusedError as error:
            # Not compared word by word: a refusal tells what else was in memory then.
            found = [] if refused else [Difference("", "an answer", str(error), INFINITE)]
        else:
            found = [Difference("", "a refusal", "an answer", INFINITE)]
            if not refused:
                found = list(differences(asked.reply, made))
        what = f"asked by {asked.caller} of the picture of {stamp_ns * 1e-9:.3f} s"
        inputs = (repr(asked.request),)
        return Compared(stream, what, asked.seconds, found, self._tolerance, inputs)


def _source(view: Heard) -> tuple[str, int]:
    """Return boot id and number of the picture of a view."""
    inputs = view.envelope.inputs
    return (inputs[0].boot_id, inputs[0].sequence) if inputs else ("", -1)
