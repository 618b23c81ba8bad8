"""Everything the console knows at the moment. Bus threads write, page connections read."""

import threading
from collections.abc import Callable, Iterable

from w2c import topics
from w2c.messages import (
    Advice,
    AllowedArea,
    CameraFrame,
    CameraView,
    ControllerStatus,
    GoalEvent,
    Health,
    ProcessTable,
    RecorderStatus,
    RobotState,
    Target,
    Turn,
)
from w2c_console import panel
from w2c_console.journal import Journal, advice_news, area_news
from w2c_console.page import AdviceNews, AreaNews, Entry, Panel, PictureHeader
from w2c_console.panel import Aged
from w2c_console.view import FrameHistory, Scene, compose

PICTURE_PERIODS_UNTIL_STALE = 10.0
"""Rendering and links are uneven: a few late pictures are no fault"""


class ConsoleModel:
    """The latest of everything, under one lock; tells listeners when there is something new."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._listeners: set[Callable[[], None]] = set()
        self._frames = FrameHistory()
        self._journal = Journal()
        self._target: Target | None = None
        self._destination: Target | None = None
        """The confirmed target that the robot moves to"""
        self._advice: AdviceNews | None = None
        self._area: AreaNews | None = None
        self._health: dict[tuple[str, str], Aged[Health]] = {}
        self._alive: frozenset[tuple[str, str]] = frozenset()
        self._robot: Aged[RobotState] | None = None
        self._controller: Aged[ControllerStatus] | None = None
        self._recorder: Aged[RecorderStatus] | None = None
        self._table: Aged[ProcessTable] | None = None

    def listen(self, callback: Callable[[], None]) -> Callable[[], None]:
        """Call back, in any thread, when there is something new. Returns the way to end it."""
        with self._lock:
            self._listeners.add(callback)

        def forget() -> None:
            with self._lock:
                self._listeners.discard(callback)

        return forget

    def on_frame(self, message: CameraFrame, now_ns: int) -> None:
        """Take in a picture."""
        with self._lock:
            self._frames.add_frame(message, now_ns)
        self._tell()

    def on_view(self, message: CameraView) -> None:
        """Take in the camera's pose at a picture."""
        with self._lock:
            self._frames.add_view(message)
        self._tell()

    def on_target(self, message: Target) -> None:
        """Take in the current target."""
        with self._lock:
            self._target = message
            self._frames.pin(message.frame_stamp_ns)
        self._tell()

    def on_advice(self, message: Advice) -> None:
        """Take in what is known of a target besides its place."""
        with self._lock:
            self._advice = advice_news(message)
        self._tell()

    def on_area(self, message: AllowedArea) -> None:
        """Take in where in a picture a hand may go."""
        news = area_news(message)
        with self._lock:
            self._area = news
        self._tell()

    def on_turn(self, message: Turn, time_ms: int) -> None:
        """Take in an exchange; `time_ms` is the wall clock [ms]."""
        target = message.target
        with self._lock:
            self._journal.add_turn(message, time_ms)
            if message.state != "moving":
                self._destination = None
            elif target is not None and target.state == "confirmed":
                self._destination = target
        self._tell()

    def on_goal(self, message: GoalEvent, time_ms: int) -> None:
        """Take in the progress of a goal; `time_ms` is the wall clock [ms]."""
        with self._lock:
            self._journal.add_goal(message, time_ms)
        self._tell()

    def on_health(self, message: Health, now_ns: int) -> None:
        """Take in the report of a process."""
        with self._lock:
            self._health[(message.service, message.instance)] = Aged(message, now_ns)

    def on_alive(self, alive: Iterable[tuple[str, str]]) -> None:
        """Take in which processes are connected."""
        with self._lock:
            self._alive = frozenset(alive)

    def on_robot(self, message: RobotState, now_ns: int) -> None:
        """Take in the state of the robot."""
        with self._lock:
            self._robot = Aged(message, now_ns)

    def on_controller(self, message: ControllerStatus, now_ns: int) -> None:
        """Take in the state of the controller."""
        with self._lock:
            self._controller = Aged(message, now_ns)

    def on_recorder(self, message: RecorderStatus, now_ns: int) -> None:
        """Take in the state of the recorder."""
        with self._lock:
            self._recorder = Aged(message, now_ns)

    def on_table(self, message: ProcessTable, now_ns: int) -> None:
        """Take in the launcher's table."""
        with self._lock:
            self._table = Aged(message, now_ns)

    def pin(self, stamp_ns: int) -> None:
        """Keep the picture that the operator speaks about."""
        with self._lock:
            self._frames.pin(stamp_ns)

    def scene(self, *, live: bool) -> Scene:
        """Return what the operator should see."""
        with self._lock:
            return compose(self._frames, self._shown(), self._destination, live=live)

    def header(self, scene: Scene, now_ns: int) -> PictureHeader:
        """Return what is said of a scene."""
        with self._lock:
            newest = self._frames.newest
        frame = scene.frame
        return PictureHeader(
            sequence=0 if frame is None else frame.sequence,
            stamp="-1" if frame is None else str(frame.stamp_ns),
            robot_boot="" if frame is None else frame.robot_boot_id,
            width=0 if frame is None else frame.width,
            height=0 if frame is None else frame.height,
            age_s=0.0 if frame is None else (now_ns - frame.arrived_ns) * 1e-9,
            silent_s=0.0 if newest is None else (now_ns - newest.arrived_ns) * 1e-9,
            limit_s=PICTURE_PERIODS_UNTIL_STALE / topics.CAMERA_FRAME.rate_hz,
            frozen=scene.frozen,
            notice=scene.notice,
            marker=scene.marker,
            destination=scene.destination,
            moving_to=scene.moving_to,
            boxes=list(scene.boxes),
            area=str(scene.area_stamp_ns),
        )

    def advice(self) -> AdviceNews | None:
        """Return what was last said of a target besides its place."""
        with self._lock:
            return self._advice

    def area(self) -> AreaNews | None:
        """Return where a hand may go, in the picture that was last asked about."""
        with self._lock:
            return self._area

    def entries(self, after: int) -> list[Entry]:
        """Return the chat after an entry."""
        with self._lock:
            return self._journal.after(after)

    def panel(self, now_ns: int) -> Panel:
        """Return the state of everything."""
        with self._lock:
            return Panel(
                robot=panel.robot_panel(self._robot, now_ns),
                controller=panel.controller_panel(self._controller, now_ns),
                recorder=panel.recorder_panel(self._recorder, now_ns),
                target=panel.target_panel(self._shown()),
                processes=panel.process_rows(self._health, self._table, self._alive, now_ns),
            )

    def _shown(self) -> Target | None:
        """Return the target that matters: one that was taken back leaves that of the motion."""
        target = self._target
        if target is None or target.state == "abandoned":
            return self._destination or target
        return target

    def _tell(self) -> None:
        with self._lock:
            listeners = list(self._listeners)
        for callback in listeners:
            callback()
