"""Messages of perception."""

from typing import Annotated

import msgspec

from w2c.messages.base import Array, Message, Name, RobotBoot, Stamp, Text, check_array


class CameraView(Message, frozen=True, kw_only=True):
    """Where the camera was when it took a frame: projects a world point into that frame."""

    stamp_ns: Stamp
    """Of the frame"""
    world_from_camera: Array
    """(4, 4)"""
    intrinsics: tuple[float, float, float, float]
    """fx, fy, cx, cy [px]"""
    width: int
    height: int
    robot_boot_id: RobotBoot = ""
    """Of the robot's process then: stamps of another one mean other instants"""
    state_ticks: Annotated[list[int], msgspec.Meta(max_length=10_000)] = []
    """Ticks of the robot's states that were taken since the view before, in order: the joint angles
    of the camera's pose are among them"""

    def __post_init__(self) -> None:
        """Refuse arrays of the wrong shape."""
        check_array("world_from_camera", self.world_from_camera, (4, 4))


class LiftRequest(Message, frozen=True, kw_only=True):
    """Which point of the world is behind this pixel of this frame?"""

    u: float
    v: float
    frame_stamp_ns: Stamp
    """Of the frame the pixel was chosen in; must be in the buffer of the last seconds"""
    footprint: Annotated[float, msgspec.Meta(gt=0, le=0.5)] = 0.03
    """Radius of what will touch the surface there [m]"""
    robot_boot_id: RobotBoot = ""
    """Of the robot when it took that frame. "" = not checked"""


class FitnessVerdict(Message, frozen=True, kw_only=True):
    """One check of whether a surface is fit to carry a hand, by its shape alone."""

    check: Name
    """known, flat, large, edge or slope"""
    fit: bool
    reason: Text
    """For the operator, with value and limit"""
    value: float
    limit: float
    """What was measured, and what it is held against [m], or [rad] for the slope"""


class LiftReply(Message, frozen=True, kw_only=True):
    """A point on a surface, with what is known of the surface around it."""

    point: Array
    """(3,) in the world [m]"""
    normal: Array
    """(3,) unit, out of the surface, towards the camera, in the world"""
    error_bound: float
    """The point is within this distance of the truth in at least 95 of 100 cases [m]: for the noise
    of depth, what may be meant at an edge, and joint angles that are off"""
    flatness: float
    """Root mean square distance of the surface to its plane inside the footprint, without the noise
    of depth [m]"""
    slope: float
    """Between normal and vertical [rad]"""
    extent: float
    """Radius of the flat surface that is seen all around the point [m]"""
    edge_distance: float = 0.0
    """To the nearest place where the surface is seen to end [m]; 0.25 where none is nearer"""
    frame_stamp_ns: Stamp
    warning: Text = ""
    """What an operator should know of where the point is: moved to a surface in front, depth of
    another instant. Of the surface: `verdicts`"""
    verdicts: Annotated[list[FitnessVerdict], msgspec.Meta(max_length=20)] = []
    """On its fitness to carry a hand of the footprint, each with its reason; [] = not judged"""

    def __post_init__(self) -> None:
        """Refuse arrays of the wrong shape."""
        check_array("point", self.point, (3,))
        check_array("normal", self.normal, (3,))
