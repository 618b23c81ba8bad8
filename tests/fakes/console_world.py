"""The services around a console: they answer at once, and remember what they were asked."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from fakes.table_picture import (
    CAMERA,
    HEIGHT,
    WIDTH,
    camera_pose,
    draw_table,
)
from w2c import topics
from w2c.bus import CallContext, InProcessBus, InProcessHub
from w2c.errors import RefusedError
from w2c.messages import (
    Advice,
    AllowedArea,
    Array,
    CameraFrame,
    CameraView,
    ConfirmRequest,
    ControllerStatus,
    ConversationState,
    Empty,
    GoalEvent,
    Health,
    PointRequest,
    RecorderStatus,
    Remark,
    ResumeReply,
    RobotState,
    SayRequest,
    StopReply,
    StopRequest,
    Target,
    Turn,
    Unchecked,
)
from w2c.messages.robot import DriverMode


@dataclass
class FakeDialogue:
    """Remembers what it was told, answers with a turn, refuses a stale confirmation."""

    bus: InProcessBus
    said: list[SayRequest] = field(default_factory=list)
    confirmed: list[ConfirmRequest] = field(default_factory=list)
    pointed: list[PointRequest] = field(default_factory=list)
    current: str = ""
    refusal: str = ""

    def __post_init__(self) -> None:
        """Serve."""
        self.bus.serve(topics.SAY, self._say)
        self.bus.serve(topics.CONFIRM, self._confirm)
        self.bus.serve(topics.POINT, self._point)

    def show(self, target: Target) -> None:
        """Make this the current target."""
        self.current = target.target_id
        self.bus.publish(topics.TARGET, target)

    def advise(
        self, target_id: str, *, caution: str = "", refusal: str = "", unchecked: str = ""
    ) -> None:
        """Publish advice on a target; the remarks in another order than their importance."""
        remarks = []
        if caution:
            remarks.append(
                Remark(kind="material", level="caution", text=caution, source="grounding")
            )
        if refusal:
            remarks.append(Remark(kind="veto", level="veto", text=refusal, source="grounding"))
        self.bus.publish(
            topics.ADVICE,
            Advice(
                stamp_ns=1,
                target_id=target_id,
                frame_stamp_ns=1,
                remarks=remarks,
                unchecked=[Unchecked(check="veto", reason=unchecked)] if unchecked else [],
                refusal=refusal,
                seconds=0.3,
            ),
        )

    def allow(self, stamp_ns: int, cells: Array) -> None:
        """Publish where a hand may go: (rows, columns) uint8, 0 = there."""
        area = AllowedArea(
            stamp_ns=stamp_ns, width=WIDTH, height=HEIGHT, cells=cells, reasons=["too steep"]
        )
        self.bus.publish(topics.ALLOWED_AREA, area)

    def ask(self, text: str, reply: str, options: list[str]) -> Turn:
        """Answer what was said with a question."""
        return self.turn(text, "question", reply, ok=False, options=options)

    def turn(
        self,
        text: str,
        module: str,
        reply: str,
        *,
        ok: bool = True,
        options: list[str] | None = None,
        target: Target | None = None,
        state: ConversationState = "idle",
    ) -> Turn:
        """Publish and return one exchange."""
        turn = Turn(
            stamp_ns=time.monotonic_ns(),
            text=text,
            module=module,
            reply=reply,
            ok=ok,
            options=options or [],
            target=target,
            state=state,
            seconds=0.42,
            steps={"selector": 0.031, "analyzer": 0.118, "grounding": 0.204, "lift": 0.006},
        )
        self.bus.publish(topics.TURN, turn)
        return turn

    def _say(self, request: SayRequest, _: CallContext) -> Turn:
        self.said.append(request)
        if self.refusal:
            raise RefusedError(self.refusal)
        return self.turn(
            request.text, "prediction.absolute", f"Is this where you mean? ({request.text})"
        )

    def _confirm(self, request: ConfirmRequest, _: CallContext) -> Turn:
        self.confirmed.append(request)
        if request.target_id != self.current:
            raise RefusedError(f"{request.target_id} is no longer the target; {self.current} is")
        return self.turn("confirm", "confirmation", f"going to {request.target_id}")

    def _point(self, request: PointRequest, _: CallContext) -> Turn:
        self.pointed.append(request)
        return self.turn("point", "point", f"pointed at {request.u:.0f}, {request.v:.0f}")


@dataclass
class FakeRobot:
    """A driver that holds when told so."""

    bus: InProcessBus
    mode: DriverMode = "tracking"
    stops: int = 0
    stamp_ns: int = 1_000_000_000
    is_late: bool = False
    """Whether its states are still those of before a resume"""

    def __post_init__(self) -> None:
        """Serve."""
        self.bus.serve(topics.ROBOT_STOP, self._stop)
        self.bus.serve(topics.ROBOT_RESUME, self._resume)

    def publish(self) -> None:
        """Publish the state."""
        if not self.is_late:
            self.stamp_ns += 2_000_000
        zero = np.zeros(2)
        state = RobotState(
            stamp_ns=self.stamp_ns,
            tick=self.stamp_ns // 2_000_000,
            position=zero,
            velocity=zero,
            torque=zero,
            sole_wrenches=np.zeros((2, 6)),
            left_wrist_wrench=np.zeros(6),
            imu_orientation=np.array([0.0, 0.0, 0.0, 1.0]),
            imu_angular_velocity=np.zeros(3),
            imu_linear_acceleration=np.zeros(3),
            command=zero,
            command_tick=0,
            mode="stopped" if self.is_late else self.mode,
        )
        self.bus.publish(topics.ROBOT_STATE, state)

    def _stop(self, _: StopRequest, __: CallContext) -> StopReply:
        self.stops += 1
        self.mode = "stopped"
        return StopReply(mode=self.mode, stamp_ns=self.stamp_ns)

    def _resume(self, _: Empty, __: CallContext) -> StopReply:
        self.mode = "tracking"
        return StopReply(mode=self.mode, stamp_ns=self.stamp_ns)


class ConsoleWorld:
    """All services around a console."""

    def __init__(self) -> None:
        self.hub = InProcessHub()
        self.console = self.hub.connect("console")
        self.camera = self.hub.connect("camera")
        self.perception = self.hub.connect("perception")
        self.controller = self.hub.connect("controller")
        self.recorder = self.hub.connect("recorder")
        self.dialogue = FakeDialogue(self.hub.connect("dialogue"))
        self.robot = FakeRobot(self.hub.connect("robot"))
        self.controller.serve(
            topics.CONTROLLER_STOP, lambda _, __: StopReply(mode="stopped", stamp_ns=1)
        )
        self.controller.serve(topics.CONTROLLER_RESUME, self._resume_controller)
        self.holding = ""
        """Why the controller holds; "" = it does not"""
        self.finds_it_again = False
        """Whether it holds again at once when it is resumed"""
        self._pictures: dict[float, bytes] = {}
        self._buses = (
            self.console, self.camera, self.perception, self.controller, self.recorder,
            self.dialogue.bus, self.robot.bus, self.hub.connect("llm"),
            self.hub.connect("grounding"),
        )  # fmt: skip

    def close(self) -> None:
        """End every service."""
        for bus in self._buses:
            bus.close()

    def take_picture(self, stamp_ns: int, *, yaw: float = 0.0, view: bool = True) -> None:
        """Publish a picture and, unless told not to, the pose of the camera at it."""
        pose = camera_pose(yaw)
        if yaw not in self._pictures:
            self._pictures[yaw] = draw_table(pose)
        frame = CameraFrame(
            stamp_ns=stamp_ns,
            frame="camera",
            width=WIDTH,
            height=HEIGHT,
            intrinsics=CAMERA,
            jpeg=self._pictures[yaw],
            depth=b"",
        )
        self.camera.publish(topics.CAMERA_FRAME, frame)
        if view:
            self.publish_view(stamp_ns, yaw=yaw)

    def publish_view(self, stamp_ns: int, *, yaw: float = 0.0) -> None:
        """Publish the pose of the camera at a picture."""
        self.perception.publish(
            topics.CAMERA_VIEW,
            CameraView(
                stamp_ns=stamp_ns,
                world_from_camera=camera_pose(yaw),
                intrinsics=CAMERA,
                width=WIDTH,
                height=HEIGHT,
            ),
        )

    def _resume_controller(self, _: Empty, __: CallContext) -> ResumeReply:
        if not self.finds_it_again:
            self.holding = ""
        return ResumeReply(holding=bool(self.holding), text=self.holding)

    def publish_controller(self, phase: str = "hold", message: str = "") -> None:
        """Publish the state of a controller on two feet, that leans in the phase `contact`."""
        if self.holding:
            phase, message = "held", self.holding
        leans = phase == "contact"
        desired = np.array([[0, 0, 420.0], [0, 0, 395.0], [0, 0, 0], [0, 0, 95.0 * leans]])
        status = ControllerStatus(
            stamp_ns=1,
            tick=1,
            phase=phase,  # type: ignore[arg-type]
            goal_id="g-1" if phase != "hold" else "",
            end_effector="right_hand" if phase != "hold" else "",
            task="contact" if phase != "hold" else "",
            distance=0.004 if leans else -1.0,
            in_contact=(True, True, False, leans),
            desired_forces=desired,
            end_effector_positions=np.zeros((4, 3)),
            loads=np.array([431.0, 402.0, 0.0, 83.0 if leans else 0.0]),
            solver_failures=0,
            lateness_us={"p50": 61.0, "p99": 214.0, "max": 1430.0, "gaps_20ms": 0.0},
            tick_us={"p50": 118.0, "p99": 240.0},
            message=message,
        )
        self.controller.publish(topics.CONTROLLER_STATUS, status)

    def publish_goal(self, state: str, reason: str = "", distance: float = -1.0) -> None:
        """Publish the progress of a goal."""
        event = GoalEvent(
            stamp_ns=1,
            goal_id="g-1",
            end_effector="right_hand",
            task="contact",
            state=state,  # type: ignore[arg-type]
            reason=reason,
            distance=distance,
        )
        self.controller.publish(topics.GOAL_EVENT, event)

    def publish_health(self) -> None:
        """Publish a report of every service that is there."""
        shares = {"camera": 31.0, "controller": 24.0, "robot": 37.0, "perception": 12.0}
        for bus in self._buses:
            health = Health(
                stamp_ns=1,
                service=bus.service,
                instance="0",
                phase="ready",
                pid=1,
                cpu_percent=shares.get(bus.service, 3.0),
                memory_mb=180.0,
            )
            bus.publish(topics.HEALTH, health)
        status = RecorderStatus(
            stamp_ns=1,
            recording=True,
            path="runs/2026-11-21T08-00-00/session.mcap",
            messages=18_204,
            bytes=83_400_000,
            lost={},
        )
        self.recorder.publish(topics.RECORDER_STATUS, status)


class Heart:
    """Repeats something until it is told to end, so that states stay fresh."""

    def __init__(self, *beats: Callable[[], None], period_s: float = 0.1) -> None:
        self._beats = beats
        self._period_s = period_s
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End."""
        self._end.set()
        self._thread.join(timeout=2.0)

    def _run(self) -> None:
        while not self._end.wait(self._period_s):
            for beat in self._beats:
                beat()
