"""Messages of the robot driver and of its camera."""

from typing import Annotated, Literal

import msgspec

from w2c.messages.base import Array, Message, Name, RobotBoot, Stamp, Text, check_array

DriverMode = Literal["tracking", "holding", "stopped"]


class JointInfo(Message, frozen=True, kw_only=True):
    """One actuated joint of the robot, in the order of all joint vectors on the bus."""

    name: Name
    stiffness: float
    """Of the flexible position control [Nm/rad]."""
    effort_limit: float
    """[Nm]"""


class RobotDescription(Message, frozen=True, kw_only=True):
    """What a controller must know of the robot before it can command it. Constant for one boot."""

    urdf: Annotated[str, msgspec.Meta(max_length=2_000_000)]
    """The model as controlled: geometry is not needed, meshes may be missing."""
    joints: list[JointInfo]
    sole_frames: tuple[Name, Name]
    """Left, right."""
    hand_frames: tuple[Name, Name]
    """Left, right. The frame of a ball-ended hand is the ball's centre."""
    hand_radius: tuple[float, float]
    """Radius of the ball at the hand frame [m], 0 for a frame on the palm. Left, right."""
    camera_frame: Name
    """Optical frame: x right, y down, z forward."""
    initial_position: Array
    """(n,) joint angles the robot stands in when it starts [rad]."""
    period_ns: Annotated[int, msgspec.Meta(gt=0)]
    """Of state and commands [ns]."""
    lock_step: bool
    """True: the robot waits for the command of each tick. False: real time."""

    def __post_init__(self) -> None:
        """Refuse arrays of the wrong shape."""
        check_array("initial_position", self.initial_position, (len(self.joints),))


class RobotState(Message, frozen=True, kw_only=True):
    """All sensors of the robot at one tick. Joint vectors are in the order of the description."""

    stamp_ns: Stamp
    tick: Stamp
    position: Array
    """(n,) [rad]"""
    velocity: Array
    """(n,) [rad/s]"""
    torque: Array
    """(n,) measured at the joint [Nm]"""
    sole_wrenches: Array
    """(2, 6) left, right: what the floor exerts, in and at the sole frame [N, Nm]"""
    left_wrist_wrench: Array
    """(6,) what the environment exerts on the hand, in and at the left hand frame [N, Nm]"""
    imu_orientation: Array
    """(4,) xyzw, world_from_imu (yaw is relative to the start)"""
    imu_angular_velocity: Array
    """(3,) in the IMU frame [rad/s]"""
    imu_linear_acceleration: Array
    """(3,) in the IMU frame, gravity included [m/s^2]"""
    command: Array
    """(n,) the joint command in force [rad]: where a controller that restarts must go on"""
    command_tick: int
    """The tick that the command in force answers; -1 before the first"""
    mode: DriverMode
    """tracking: follows commands. holding: commands stopped coming, the last one is held.
    stopped: an operator said stop; held until resumed."""

    def __post_init__(self) -> None:
        """Refuse arrays of the wrong shape; a sensor that reads NaN is the receiver's to judge."""
        joints = self.position.shape if self.position.ndim == 1 else (None,)
        check_array("position", self.position, joints, finite=False)
        check_array("velocity", self.velocity, joints, finite=False)
        check_array("torque", self.torque, joints, finite=False)
        check_array("command", self.command, joints, finite=False)
        check_array("sole_wrenches", self.sole_wrenches, (2, 6), finite=False)
        check_array("left_wrist_wrench", self.left_wrist_wrench, (6,), finite=False)
        check_array("imu_orientation", self.imu_orientation, (4,), finite=False)
        check_array("imu_angular_velocity", self.imu_angular_velocity, (3,), finite=False)
        check_array("imu_linear_acceleration", self.imu_linear_acceleration, (3,), finite=False)


class RobotStatistics(Message, frozen=True, kw_only=True):
    """How the driver's loop keeps time; published at 2 Hz of robot time."""

    stamp_ns: Stamp
    tick: Stamp
    pace: float
    """Robot time over wall time since the last of these: 1 in real time"""
    real_time_factor: float
    """What the pace would be with a core for the machine alone: the period over the processor time
    of its step, since the last of these. Below 1 it cannot keep real time"""
    late_periods: int
    """Periods since the start that began more than a period after they were due"""
    gaps_20ms: int
    """Of these, by more than 20 ms: robot time fell behind for good"""
    lateness_p50_us: float
    lateness_p99_us: float
    lateness_max_us: float
    """Of the last 5000 periods; all zero in lock step, where nothing is due"""
    memory_locked: bool
    real_time_priority: bool


class PushRequest(Message, frozen=True, kw_only=True):
    """Push a body at its centre of mass. Simulation only: a real robot is pushed by people."""

    link: Name = "torso_2_link"
    """A link of the robot, or an object of the scene"""
    force: Array
    """(3,) in the world [N]"""
    duration_s: Annotated[float, msgspec.Meta(ge=0.0, le=60.0)] = 0.1
    tick: Annotated[int, msgspec.Meta(ge=-1)] = -1
    """When it begins; -1 = at the next tick"""

    def __post_init__(self) -> None:
        """Refuse NaN, infinity and wrong shapes."""
        check_array("force", self.force, (3,))


class PushReply(Message, frozen=True, kw_only=True):
    """The push was accepted."""

    tick: Stamp
    """When it begins, or has begun"""


class CameraFrame(Message, frozen=True, kw_only=True):
    """One picture with depth from the head camera, taken at `stamp_ns` of robot time."""

    stamp_ns: Stamp
    frame: Name
    """The optical frame of the robot's model."""
    width: Annotated[int, msgspec.Meta(gt=0, le=8192)]
    height: Annotated[int, msgspec.Meta(gt=0, le=8192)]
    intrinsics: tuple[float, float, float, float]
    """fx, fy, cx, cy [px]; the centre of pixel (0, 0) is at (0.5, 0.5)."""
    jpeg: Annotated[bytes, msgspec.Meta(max_length=20_000_000)]
    depth: Annotated[bytes, msgspec.Meta(max_length=40_000_000)]
    """zstd of little-endian uint16 [v, u], z-depth in units of `depth_unit`; 0 = unknown.
    Empty: no depth."""
    depth_unit: float = 0.00025
    """[m]"""
    depth_stamp_ns: Annotated[int, msgspec.Meta(ge=-1)] = -1
    """When depth was taken, where that was another instant than `stamp_ns`, the colours'; seen from
    the same optical frame, which may have moved meanwhile. -1 = with the colours"""
    robot_boot_id: RobotBoot = ""
    """Of the robot whose time the stamps are"""


class CaptureRequest(Message, frozen=True, kw_only=True):
    """Take a picture now, beside the regular ones."""

    shadows: bool = False
    antialiasing: bool = False


class PictureRequest(Message, frozen=True, kw_only=True):
    """A picture of the robot from outside. Simulation only."""

    view: Literal["side", "front", "over_shoulder"] = "side"
    width: Annotated[int, msgspec.Meta(ge=16, le=1920)] = 960
    height: Annotated[int, msgspec.Meta(ge=16, le=1080)] = 720


class Picture(Message, frozen=True, kw_only=True):
    """A JPEG."""

    stamp_ns: Stamp
    jpeg: Annotated[bytes, msgspec.Meta(max_length=20_000_000)]


class Truth(Message, frozen=True, kw_only=True):
    """What the simulator knows and a real robot would not. Evaluation, scenes and tests only."""

    stamp_ns: Stamp
    tick: Stamp
    generalized_position: Array
    """(nq,) of the simulator, its own order: what the camera process draws"""
    world_from_base: Array
    """(7,) position, quaternion xyzw"""
    end_effector_positions: Array
    """(4, 3) left foot, right foot, left hand, right hand, in the world [m]"""
    contact_forces: Array
    """(4, 3) what the environment exerts on them, in the world [N]"""
    fell: bool
    """Something other than feet and hands touches, or the base is lower than it can stand"""
    scene: dict[str, tuple[float, float, float]] = {}
    """Name -> position in the world [m] of the movable objects"""
    description: Text = ""

    def __post_init__(self) -> None:
        """Refuse arrays of the wrong shape."""
        check_array("generalized_position", self.generalized_position, (None,))
        check_array("world_from_base", self.world_from_base, (7,))
        check_array("end_effector_positions", self.end_effector_positions, (4, 3))
        check_array("contact_forces", self.contact_forces, (4, 3))
