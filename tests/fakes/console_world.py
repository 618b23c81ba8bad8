"""The services around a console: they answer at once, and remember what they were asked."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np

from w2c import geometry, topics
from w2c.bus import CallContext, InProcessBus, InProcessHub
from w2c.errors import RefusedError
from w2c.messages import (
    Array,
    Box,
    CameraFrame,
    CameraView,
    ConfirmRequest,
    ControllerStatus,
    Empty,
    GoalEvent,
    Health,
    PointRequest,
    RecorderStatus,
    RobotState,
    SayRequest,
    StopReply,
    StopRequest,
    Target,
    Turn,
)
from w2c.messages.robot import DriverMode

WIDTH, HEIGHT = 1280, 720
CAMERA = geometry.intrinsics_from_fov(WIDTH, HEIGHT, np.deg2rad(50.0))
BOOK_TOP = np.array([0.52, -0.18, 0.80])
"""Middle of the book, in the world [m]"""
TABLE_HEIGHT = 0.75


def camera_pose(yaw: float = 0.0) -> Array:
    """Return world_from_camera (4, 4) of a head that looks down, turned left by `yaw` [rad]."""
    pitch = np.deg2rad(44.0)
    forward = np.array([np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), -np.sin(pitch)])
    right = np.array([np.sin(yaw), -np.cos(yaw), 0.0])
    down = np.cross(forward, right)
    return geometry.transform(np.column_stack([right, down, forward]), [0.12, 0.0, 1.45])


def pixel_of(point: Array, world_from_camera: Array) -> tuple[float, float]:
    """Return the pixel (u, v) of a point of the world [m]."""
    return CAMERA.pixel_from_point(geometry.apply(geometry.inverse(world_from_camera), point))


def draw_table(world_from_camera: Array) -> bytes:
    """Return the JPEG of a table with a book, a cup and a plate."""
    image = np.full((HEIGHT, WIDTH, 3), (78, 84, 92), np.uint8)

    def fill(corners: list[tuple[float, float, float]], colour: tuple[int, int, int]) -> None:
        pixels = [pixel_of(np.array(corner), world_from_camera) for corner in corners]
        cv2.fillPoly(image, [np.array(pixels, np.int32)], colour, cv2.LINE_AA)

    def slab(x: float, y: float, size: tuple[float, float, float], colour: Array) -> None:
        length, width, height = size
        low, high = TABLE_HEIGHT, TABLE_HEIGHT + height
        left, right, near, far = y + width / 2, y - width / 2, x - length / 2, x + length / 2
        dark, bright = _colour(0.6 * colour), _colour(colour)
        fill([(near, left, low), (near, right, low), (near, right, high), (near, left, high)], dark)
        fill(
            [(near, left, high), (near, right, high), (far, right, high), (far, left, high)], bright
        )

    for line in np.linspace(-1.6, 1.6, 17):  # floor
        ends = [pixel_of(np.array([x, line, 0.0]), world_from_camera) for x in (0.9, 3.5)]
        start, end = ((int(u), int(v)) for u, v in ends)
        cv2.line(image, start, end, (88, 94, 102), 2, cv2.LINE_AA)
    slab(0.75, 0.0, (0.8, 1.5, 0.03), np.array([120, 158, 190]))
    slab(BOOK_TOP[0], BOOK_TOP[1], (0.2, 0.27, 0.05), np.array([96, 128, 60]))
    slab(0.78, -0.38, (0.2, 0.2, 0.035), np.array([225, 228, 230]))
    base = pixel_of(np.array([0.8, 0.2, TABLE_HEIGHT + 0.03]), world_from_camera)
    top = pixel_of(np.array([0.8, 0.2, TABLE_HEIGHT + 0.13]), world_from_camera)
    u, v, height = int(base[0]), int(base[1]), int(base[1] - top[1])
    cv2.rectangle(image, (u - 38, v - height), (u + 38, v), (52, 60, 196), -1)
    cv2.ellipse(image, (u, v), (38, 15), 0, 0, 360, (52, 60, 196), -1, cv2.LINE_AA)
    cv2.ellipse(image, (u, v - height), (38, 15), 0, 0, 360, (40, 44, 130), -1, cv2.LINE_AA)
    noise = np.random.default_rng(0).normal(0.0, 3.0, image.shape)
    image = np.clip(cv2.GaussianBlur(image, (3, 3), 0) + noise, 0, 255).astype(np.uint8)
    done, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 92])
    if not done:
        raise AssertionError("cv2 cannot encode a JPEG")
    return bytes(data.tobytes())


def _colour(values: Array) -> tuple[int, int, int]:
    blue, green, red = (int(value) for value in values)
    return blue, green, red


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

    def turn(self, text: str, module: str, reply: str, *, ok: bool = True) -> Turn:
        """Publish and return one exchange."""
        turn = Turn(
            stamp_ns=time.monotonic_ns(),
            text=text,
            module=module,
            reply=reply,
            ok=ok,
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

    def __post_init__(self) -> None:
        """Serve."""
        self.bus.serve(topics.ROBOT_STOP, self._stop)
        self.bus.serve(topics.ROBOT_RESUME, self._resume)

    def publish(self) -> None:
        """Publish the state."""
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
            mode=self.mode,
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

    def publish_controller(self, phase: str = "hold", message: str = "") -> None:
        """Publish the state of a controller on two feet, that leans in the phase `contact`."""
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


def make_target(
    target_id: str,
    stamp_ns: int,
    *,
    point: Array | None = BOOK_TOP,
    yaw: float = 0.0,
    corrections: int = 0,
    state: str = "proposed",
    warning: str = "",
) -> Target:
    """Return a target on the book, chosen in the picture of `stamp_ns`."""
    u, v = pixel_of(BOOK_TOP if point is None else point, camera_pose(yaw))
    corners = [BOOK_TOP + np.array([x, y, 0.0]) for x in (-0.1, 0.1) for y in (-0.135, 0.135)]
    pixels = np.array([pixel_of(corner, camera_pose(yaw)) for corner in corners])  # (4, 2)
    (left, top), (right, bottom) = pixels.min(axis=0), pixels.max(axis=0)
    return Target(
        target_id=target_id,
        frame_stamp_ns=stamp_ns,
        u=float(u),
        v=float(v),
        point=point,
        normal=None if point is None else np.array([0.0, 0.0, 1.0]),
        state=state,  # type: ignore[arg-type]
        corrections=corrections,
        instruction="Place your right hand on top of the book",
        boxes=[
            Box(
                left=float(left),
                top=float(top),
                right=float(right),
                bottom=float(bottom),
                score=1.0,
            )
        ],
        phrases=["book"],
        warning=warning,
    )


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
