"""Remembers what the recorded perception remembered, and answers what it was asked."""

from collections.abc import Callable

from w2c.errors import RefusedError
from w2c.messages import (
    AllowedAreaRequest,
    CameraFrame,
    CameraView,
    ControllerStatus,
    HeightFieldRequest,
    LiftRequest,
    Message,
    PointCloudRequest,
    RobotDescription,
    RobotState,
)
from w2c.stance import Stance
from w2c.through import Asked, Heard
from w2c_perception.answers import Answers
from w2c_perception.config import PerceptionConfig
from w2c_perception.memory import PictureMemory
from w2c_perception.track import RobotTrack


class Player:
    """One perception that follows one robot process."""

    def __init__(self, config: PerceptionConfig, description: RobotDescription, robot: str) -> None:
        """Begin with nothing seen.

        Args:
            config: Of the recorded process.
            description: Of the robot.
            robot: Boot id.
        """
        self._memory = PictureMemory(config.history, config.max_frames, config.unpacked_frames)
        self._memory.forget(robot)
        self._robot = robot
        self._track = RobotTrack(description, robot, config.history)
        self._answers = Answers(config, self._memory)
        self._followed = ""
        """Boot id of the controller whose world this is"""

    def take(self, state: RobotState, status: Heard | None) -> None:
        """Take a state, with what a controller last said before it.

        Raises:
            GeometryError: it was refused then, too, and is not used.
        """
        world = self._track.world
        self._track.add(state)
        if status is not None and status.envelope.boot_id != self._followed:
            message: ControllerStatus = status.message
            if self._track.follow(message):
                self._followed = status.envelope.boot_id
        if self._track.world not in (world, 0):
            self._memory.forget(self._robot)
        if self._track.world != world == 0:
            self._followed = ""

    @property
    def stance(self) -> Stance | None:
        """Where the feet stand; None while it is not known."""
        return self._track.stance

    @property
    def world(self) -> int:
        """Number of the present world, 0 before the first."""
        return self._track.world

    def place(self, frame: CameraFrame) -> CameraView:
        """Remember a picture, and return where it was taken from.

        Raises:
            RefusedError: no joint angles at its stamp.
            GeometryError: it is not of this robot's camera.
        """
        view = self._track.place(frame)
        self._memory.add(view)
        return CameraView(
            stamp_ns=frame.stamp_ns,
            world_from_camera=view.pose.world_from_camera,
            intrinsics=frame.intrinsics,
            width=frame.width,
            height=frame.height,
            robot_boot_id=self._robot,
        )

    def answer(self, asked: Asked) -> Message:
        """Answer a recorded call. Raises W2CError where it is refused."""
        kinds: dict[type[Message], Callable[..., Message]] = {
            LiftRequest: self._answers.lift,
            HeightFieldRequest: self._answers.heights,
            AllowedAreaRequest: self._answers.allowed,
            PointCloudRequest: self._answers.cloud,
        }
        request = asked.request
        handler = kinds.get(type(request)) if request is not None else None
        if handler is None:
            raise RefusedError(f"this version knows no call {asked.service}/{asked.method}")
        return handler(request)
