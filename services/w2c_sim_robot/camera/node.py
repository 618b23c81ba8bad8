"""The camera on the bus: the simulator's truth in, pictures out.

OpenGL belongs to one thread, so calls are handed to the loop that draws the stream.
"""

import logging
import threading
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from pathlib import Path
from queue import Empty as QueueEmpty
from queue import SimpleQueue

import msgspec

from w2c import topics
from w2c.bus import Bus, CallContext, Received
from w2c.clock import Clock
from w2c.errors import ConfigError, DeadlineError, RefusedError
from w2c.messages import CameraFrame, CaptureRequest, Message, Picture, PictureRequest, Truth
from w2c_sim_robot.camera.config import CameraConfig
from w2c_sim_robot.camera.studio import Studio
from w2c_sim_robot.scenes import scene as scenes

log = logging.getLogger("w2c.camera")

_POLL_S = 0.2
Draw = Callable[[Studio, Received[Truth]], Message]
Job = tuple["Future[Message]", Draw]


class CameraNode:
    """Draws the newest truth at a steady rate, and whenever it is asked."""

    def __init__(self, config: CameraConfig, bus: Bus, clock: Clock) -> None:
        self._config = config
        self._bus = bus
        self._clock = clock
        self._jobs: SimpleQueue[Job] = SimpleQueue()
        self._studio: Studio | None = None
        self._mismatch = ""

    def configure(self) -> None:
        """Build the robot's model with the scene, and answer who asks for pictures."""
        scene = scenes.load(Path(self._config.scene)) if self._config.scene else None
        self._studio = Studio(
            scene,
            size=(self._config.width, self._config.height),
            jpeg_quality=self._config.jpeg_quality,
        )
        self._truth = self._bus.latest(topics.TRUTH)
        self._bus.serve(topics.CAPTURE, self._capture)
        self._bus.serve(topics.PICTURE, self._picture)

    def run(self, stop: threading.Event) -> None:
        """Draw until `stop`."""
        while self._config.rate == 0.0 and not stop.is_set():
            self._do_jobs(_POLL_S)
        if stop.is_set():
            return
        period_ns = round(1e9 / self._config.rate)
        next_ns = self._clock.now_ns()
        while not stop.is_set():
            remaining_s = (next_ns - self._clock.now_ns()) * 1e-9
            if remaining_s > 0:
                self._do_jobs(min(remaining_s, _POLL_S))
                continue
            received = self._truth.wait(_POLL_S)
            if received is not None:
                self._publish(received)
                # Steady where it can be; a camera that is late does not hurry after.
                next_ns = max(next_ns + period_ns, self._clock.now_ns())
            self._do_jobs(0.0)

    def close(self) -> None:
        """Free the graphics context."""
        if self._studio is not None:
            self._studio.close()

    def _publish(self, received: Received[Truth]) -> None:
        """Draw the stream's next picture."""
        try:
            frame, drawn = self._draw(received)
        except ConfigError as error:
            # Said once, counted always: a picture of another scene would be a lie.
            self._bus.count("truth of another model")
            if str(error) != self._mismatch:
                log.error("%s", error)
            self._mismatch = str(error)
            return
        self._mismatch = ""
        self._bus.publish(topics.CAMERA_FRAME, frame, [one.as_input() for one in drawn])

    def _draw(self, received: Received[Truth]) -> tuple[CameraFrame, list[Received[Truth]]]:
        """Return the stream's next picture, and what it was drawn from. Raises ConfigError."""
        drawn = [received]
        early: bytes | None = None
        self._pose(received.message)
        if self._config.depth and self._config.depth_delay > 0.0:
            early = self._ready().depth()
            drawn.append(self._later(received))
            self._pose(drawn[-1].message)
        newest = drawn[-1]
        frame = self._ready().frame(
            newest.message.stamp_ns,
            shadows=self._config.shadows,
            antialiasing=self._config.antialiasing,
            depth=self._config.depth and early is None,
            robot_boot_id=newest.envelope.boot_id,
        )
        if early is not None:
            stamp_ns = received.message.stamp_ns
            frame = msgspec.structs.replace(frame, depth=early, depth_stamp_ns=stamp_ns)
        return frame, drawn

    def _later(self, first: Received[Truth]) -> Received[Truth]:
        """Return the truth of the depth delay after another; the newest where none comes."""
        newest = first
        wanted_ns = first.message.stamp_ns + round(self._config.depth_delay * 1e9)
        deadline_ns = self._clock.now_ns() + round(2e9 * self._config.depth_delay)
        while newest.message.stamp_ns < wanted_ns and self._clock.now_ns() < deadline_ns:
            received = self._truth.wait(_POLL_S)
            if received is None:
                continue
            if received.envelope.boot_id != first.envelope.boot_id:
                break  # the robot started anew: its time means another
            newest = received
        return newest

    def _pose(self, truth: Truth) -> None:
        self._ready().pose(truth.generalized_position)

    def _ready(self) -> Studio:
        if self._studio is None:
            raise RefusedError("the camera is not configured yet; ask again when it is ready")
        return self._studio

    def _do_jobs(self, timeout_s: float) -> None:
        """Do the first call that arrives within the time-out, and those that wait by then."""
        try:
            result, draw = (
                self._jobs.get(timeout=timeout_s) if timeout_s > 0 else self._jobs.get_nowait()
            )
        except QueueEmpty:
            return
        if not result.set_running_or_notify_cancel():
            return
        try:
            result.set_result(self._answer(draw))
        except Exception as error:  # handed to the caller's thread, not swallowed
            result.set_exception(error)

    def _answer(self, draw: Draw) -> Message:
        newest = self._truth.last()
        if newest is None:
            raise RefusedError(
                "the robot has not said yet where it is; start `w2c robot` and ask again"
            )
        try:
            self._pose(newest.message)
        except ConfigError as error:
            raise RefusedError(str(error)) from error
        return draw(self._ready(), newest)

    def _ask(self, draw: Draw, timeout_s: float) -> Message:
        """Let the drawing loop do it, and wait for the result."""
        result: Future[Message] = Future()
        self._jobs.put((result, draw))
        try:
            return result.result(timeout_s)
        except FutureTimeoutError as error:
            result.cancel()
            raise DeadlineError(f"no picture within {timeout_s:g} s; the camera is busy") from error

    def _capture(self, request: CaptureRequest, _context: CallContext) -> CameraFrame:
        """Return a picture of the head camera; on the stream too, for perception to know it."""
        frame = self._ask(
            lambda studio, truth: studio.frame(
                truth.message.stamp_ns,
                shadows=request.shadows,
                antialiasing=request.antialiasing,
                robot_boot_id=truth.envelope.boot_id,
            ),
            topics.CAPTURE.timeout_s,
        )
        if not isinstance(frame, CameraFrame):
            raise TypeError(f"a capture gave {type(frame).__name__}")
        self._bus.publish(topics.CAMERA_FRAME, frame)
        return frame

    def _picture(self, request: PictureRequest, _context: CallContext) -> Picture:
        picture = self._ask(
            lambda studio, truth: studio.picture(truth.message.stamp_ns, request),
            topics.PICTURE.timeout_s,
        )
        if not isinstance(picture, Picture):
            raise TypeError(f"a picture gave {type(picture).__name__}")
        return picture
