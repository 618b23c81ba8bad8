"""Perception on the bus: pictures and joint angles in, camera poses and lifted pixels out."""

import logging
import threading
from collections import deque

from w2c import topics
from w2c.bus import Bus, Received
from w2c.clock import Clock
from w2c.errors import CallError, GeometryError, RefusedError
from w2c.messages import CameraFrame, CameraView, Empty, RobotState
from w2c_perception.answers import Answers
from w2c_perception.config import PerceptionConfig
from w2c_perception.memory import PictureMemory
from w2c_perception.track import RobotTrack

log = logging.getLogger("w2c.perception")

FRAME_QUEUE = 8
"""Pictures that may wait: each must be known before an operator can point into it"""
STATUS_AGE_NS = 500_000_000
"""An older status may be of a controller that is no more [ns of robot time]"""
MOST_TICKS = 1000
"""Told of with a view: ten seconds without pictures"""
_DESCRIBE_TIMEOUT_S = 2.0
_WAIT_FOR_STATE_S = 1.0


class PerceptionNode:
    """Keeps the last pictures and where they were taken from."""

    def __init__(self, config: PerceptionConfig, bus: Bus, clock: Clock) -> None:
        self._config = config
        self._bus = bus
        self._clock = clock
        self._memory = PictureMemory(config.history, config.max_frames, config.unpacked_frames)
        self._track: RobotTrack | None = None
        """Used by the loop alone"""
        self._controller_boot_id = ""
        """Of the controller whose world is known to be this one"""
        self._taken: deque[int] = deque(maxlen=MOST_TICKS)
        """Ticks of the states since the last view"""

    def configure(self) -> None:
        """Subscribe, and answer who asks."""
        self._newest_state = self._bus.latest(topics.ROBOT_STATE)
        self._status = self._bus.latest(topics.CONTROLLER_STATUS)
        self._frames = self._bus.queue(topics.CAMERA_FRAME, size=FRAME_QUEUE)
        answers = Answers(self._config, self._memory)
        self._bus.serve(topics.LIFT, answers.lift, workers=2)
        self._bus.serve(topics.HEIGHT_FIELD, answers.heights)
        self._bus.serve(topics.POINT_CLOUD, answers.cloud)
        self._bus.serve(topics.FIND_ALLOWED_AREA, answers.allowed)

    def run(self, stop: threading.Event) -> None:
        """Remember until `stop`."""
        waiting: Received[CameraFrame] | None = None
        waiting_since_ns = 0
        period_s = 1.0 / self._config.state_rate
        while not stop.is_set():
            track = self._track
            if track is None:
                self._describe(stop)
                continue
            if not self._take_state(track, period_s):
                continue
            if waiting is None:
                waiting = self._frames.receive(0.0)
                waiting_since_ns = self._clock.now_ns()
            # A picture is placed once there are joint angles on both sides of its stamp.
            if waiting is not None:
                expired = self._clock.now_ns() - waiting_since_ns > _WAIT_FOR_STATE_S * 1e9
                known = _newest_stamp(waiting.message) <= track.newest_ns
                if expired or (known and not self._expects_controller(track)):
                    self._remember(waiting, track)
                    waiting = None
            stop.wait(period_s)

    def close(self) -> None:
        """Forget everything."""
        self._memory.forget("")

    def _describe(self, stop: threading.Event) -> None:
        """Ask the robot what it is, until it answers."""
        try:
            reply = self._bus.call(topics.DESCRIBE, Empty(), timeout_s=_DESCRIBE_TIMEOUT_S)
            self._track = RobotTrack(reply.message, reply.envelope.boot_id, self._config.history)
            self._memory.forget(reply.envelope.boot_id)
            log.info("robot described", extra={"joints": len(reply.message.joints)})
        except CallError as error:
            log.debug("the robot does not answer yet: %s", error)
            stop.wait(0.5)
        except GeometryError as error:
            # Only another robot can help; it is asked again, for it may be restarted with another
            # model.
            log.error("%s", error)
            self._bus.count("description refused")
            stop.wait(2.0)

    def _take_state(self, track: RobotTrack, timeout_s: float) -> bool:
        """Remember the newest state. Returns False where the robot started anew."""
        received = self._newest_state.wait(timeout_s)
        if received is None:
            return True
        if received.envelope.boot_id != track.boot_id:
            log.info("the robot started anew")
            self._track = None
            self._taken.clear()
            self._memory.forget("")
            return False
        state: RobotState = received.message
        world = track.world
        try:
            track.add(state)
        except GeometryError as error:
            self._bus.count("state without joint angles")
            log.debug("%s", error)
            return True
        self._taken.append(state.tick)
        self._follow_controller(track, state.stamp_ns)
        if track.world != world:
            self._change_world(world, track)
        return True

    def _follow_controller(self, track: RobotTrack, now_ns: int) -> None:
        """Take the world of a controller that is met for the first time, of this boot."""
        received = self._status.last()
        if received is None or received.envelope.boot_id == self._controller_boot_id:
            return
        status = received.message
        if not 0 <= now_ns - status.stamp_ns <= STATUS_AGE_NS:
            return  # of before the robot started anew, or of a controller that is dead
        try:
            if track.follow(status):
                self._controller_boot_id = received.envelope.boot_id
        except GeometryError as error:
            self._bus.count("status of the controller refused")
            log.debug("%s", error)

    def _expects_controller(self, track: RobotTrack) -> bool:
        """Tell whether a controller is there that has just not said yet where the feet are."""
        if self._controller_boot_id or track.age_ns > STATUS_AGE_NS:
            return False
        return any(service == "controller" for service, _ in self._bus.alive())

    def _change_world(self, former: int, track: RobotTrack) -> None:
        """Say that the robot stands, or that nobody knows where it is any more."""
        if track.world == 0:
            log.warning("no foot on the ground: pictures have no place in the world")
        else:
            # What was seen before the robot was lifted, or in a world of this process' own, is
            # somewhere else now.
            log.info("the robot stands in another world", extra={"world": track.world})
            self._memory.forget(track.boot_id)
        if former == 0:
            # Nobody moves the controller's world but the controller: it is to be heard again.
            self._controller_boot_id = ""

    def _remember(self, received: Received[CameraFrame], track: RobotTrack) -> None:
        """Place a picture in the world, keep it, and tell where it was taken from."""
        frame = received.message
        try:
            if received.envelope.robot != self._bus.robot:
                raise GeometryError(
                    f"picture of robot '{received.envelope.robot}', this is perception of "
                    f"'{self._bus.robot}'"
                )
            if frame.robot_boot_id not in ("", track.boot_id):
                raise GeometryError(
                    f"picture of robot process '{frame.robot_boot_id}', the joint angles are of "
                    f"'{track.boot_id}': the robot started anew"
                )
            view = track.place(frame)
        except RefusedError as error:
            self._bus.count("picture without joint angles")
            log.warning("picture dropped: %s", error, extra={"stamp_ns": frame.stamp_ns})
            return
        except GeometryError as error:
            self._bus.count("picture refused")
            log.warning("picture refused: %s", error, extra={"stamp_ns": frame.stamp_ns})
            return
        self._memory.add(view)
        message = CameraView(
            stamp_ns=frame.stamp_ns,
            world_from_camera=view.pose.world_from_camera,
            intrinsics=frame.intrinsics,
            width=frame.width,
            height=frame.height,
            robot_boot_id=track.boot_id,
            state_ticks=list(self._taken),
        )
        self._taken.clear()
        self._bus.publish(topics.CAMERA_VIEW, message, [received.as_input()])


def _newest_stamp(frame: CameraFrame) -> int:
    """Return when the later of colours and depth was taken [ns]."""
    return max(frame.stamp_ns, frame.depth_stamp_ns)
