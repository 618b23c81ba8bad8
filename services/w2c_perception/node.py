"""Perception on the bus: pictures and joint angles in, camera poses and lifted pixels out."""

import logging
import threading

from w2c import topics
from w2c.bus import Bus, CallContext, Received
from w2c.clock import Clock
from w2c.errors import CallError, GeometryError, MessageError, RefusedError
from w2c.messages import (
    CameraFrame,
    CameraView,
    Empty,
    HeightField,
    HeightFieldRequest,
    LiftReply,
    LiftRequest,
    RobotState,
)
from w2c_perception.buffer import StateBuffer, View, ViewBuffer
from w2c_perception.config import PerceptionConfig
from w2c_perception.heights import Area, height_field
from w2c_perception.kinematics import CameraKinematics
from w2c_perception.lift import lift
from w2c_perception.plane import Depth

log = logging.getLogger("w2c.perception")

FRAME_QUEUE = 8
"""Pictures that may wait: each must be known before an operator can point into it"""
CAMERA_REACH = 2.0
"""A joint that is off by an angle moves what the camera sees by no more than this times the
angle [m]"""
_DESCRIBE_TIMEOUT_S = 2.0
_WAIT_FOR_STATE_S = 1.0


class PerceptionNode:
    """Keeps the last pictures and where they were taken from."""

    def __init__(self, config: PerceptionConfig, bus: Bus, clock: Clock) -> None:
        self._config = config
        self._bus = bus
        self._clock = clock
        # Held for milliseconds: by the loop that remembers, by the handlers that look.
        self._lock = threading.Lock()
        self._views = ViewBuffer(config.history, config.max_frames)
        self._states = StateBuffer(config.history)
        self._kinematics: CameraKinematics | None = None
        self._robot_boot = ""

    def configure(self) -> None:
        """Subscribe, and answer who asks."""
        self._newest_state = self._bus.latest(topics.ROBOT_STATE)
        self._frames = self._bus.queue(topics.CAMERA_FRAME, size=FRAME_QUEUE)
        self._bus.serve(topics.LIFT, self._lift, workers=2)
        self._bus.serve(topics.HEIGHT_FIELD, self._heights)

    def run(self, stop: threading.Event) -> None:
        """Remember until `stop`."""
        waiting: Received[CameraFrame] | None = None
        waiting_since_ns = 0
        period_s = 1.0 / self._config.state_rate
        while not stop.is_set():
            if self._kinematics is None:
                self._describe(stop)
                continue
            self._take_state(period_s)
            if waiting is None:
                waiting = self._frames.receive(0.0)
                waiting_since_ns = self._clock.now_ns()
            if waiting is None:
                continue
            # A picture is placed once there are joint angles on both sides of its stamp.
            expired = self._clock.now_ns() - waiting_since_ns > _WAIT_FOR_STATE_S * 1e9
            if waiting.message.stamp_ns <= self._states.newest_ns or expired:
                self._remember(waiting)
                waiting = None
            stop.wait(period_s)

    def close(self) -> None:
        """Forget everything."""
        with self._lock:
            self._views.clear()

    def _describe(self, stop: threading.Event) -> None:
        """Ask the robot what it is, until it answers."""
        try:
            reply = self._bus.call(topics.DESCRIBE, Empty(), timeout_s=_DESCRIBE_TIMEOUT_S)
            self._kinematics = CameraKinematics(reply.message)
            log.info("robot described", extra={"joints": self._kinematics.joint_count})
        except CallError as error:
            log.debug("the robot does not answer yet: %s", error)
            stop.wait(0.5)
        except GeometryError as error:
            # Only another robot can help; it is asked again, for it may be restarted with another
            # model.
            log.error("%s", error)
            self._bus.count("description refused")
            stop.wait(2.0)

    def _take_state(self, timeout_s: float) -> None:
        """Remember the newest joint angles; a robot that started anew is described anew."""
        received = self._newest_state.wait(timeout_s)
        if received is None:
            return
        state: RobotState = received.message
        with self._lock:
            if received.envelope.boot_id != self._robot_boot:
                if self._robot_boot:
                    log.info("the robot started anew")
                    self._views.clear()
                    self._states = StateBuffer(self._config.history)
                    self._kinematics = None
                self._robot_boot = received.envelope.boot_id
            self._states.add(state.stamp_ns, state.position)

    def _remember(self, received: Received[CameraFrame]) -> None:
        """Place a picture in the world, keep it, and tell where it was taken from."""
        frame = received.message
        try:
            if self._kinematics is None:
                raise RefusedError("the robot has not been described yet")
            with self._lock:
                joints = self._states.at(frame.stamp_ns)
            world_from_camera = self._kinematics.world_from_camera(joints.position)
            arms = self._kinematics.arms_in_world(joints.position)
        except (RefusedError, GeometryError) as error:
            self._bus.count("picture without joint angles")
            log.warning("picture dropped: %s", error, extra={"stamp_ns": frame.stamp_ns})
            return
        with self._lock:
            self._views.add(View(frame, world_from_camera, arms, CAMERA_REACH * joints.uncertainty))
        view = CameraView(
            stamp_ns=frame.stamp_ns,
            world_from_camera=world_from_camera,
            intrinsics=frame.intrinsics,
            width=frame.width,
            height=frame.height,
        )
        self._bus.publish(topics.CAMERA_VIEW, view, [received.as_input()])

    def _lift(self, request: LiftRequest, _context: CallContext) -> LiftReply:
        """Answer what is behind a pixel."""
        view, depth = self._look(request.frame_stamp_ns)
        surface = lift(
            depth,
            view.intrinsics,
            view.world_from_camera,
            request.u,
            request.v,
            footprint=request.footprint,
            depth_unit=view.depth_unit,
            pose_error=view.pose_error,
        )
        return LiftReply(
            point=surface.point,
            normal=surface.normal,
            error_bound=surface.error_bound,
            flatness=surface.flatness,
            slope=surface.slope,
            extent=surface.extent,
            frame_stamp_ns=view.stamp_ns,
            warning=surface.warning,
        )

    def _heights(self, request: HeightFieldRequest, _context: CallContext) -> HeightField:
        """Answer how high things stand in a picture."""
        view, depth = self._look(request.frame_stamp_ns)
        area = Area()
        heights = height_field(depth, view.intrinsics, view.world_from_camera, view.arms, area)
        return HeightField(
            stamp_ns=view.stamp_ns,
            origin=(area.x[0], area.y[0]),
            cell=area.cell,
            heights=heights,
        )

    def _look(self, stamp_ns: int) -> tuple[View, Depth]:
        """Return a remembered view with its depth (h, w) [m]. Raises RefusedError."""
        with self._lock:
            view = self._views.get(stamp_ns)
        try:
            return view, view.unpack_depth()
        except MessageError as error:
            raise RefusedError(
                f"the picture of {view.stamp_ns} ns has no usable depth: {error}"
            ) from error
