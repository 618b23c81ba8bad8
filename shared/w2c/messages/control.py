"""Messages to and from the controller."""

from typing import Annotated, Any, Literal

import msgspec
import numpy as np

from w2c.messages.base import Array, Message, Name, Stamp, Text, check_array
from w2c.messages.terrain import HeightField

EndEffector = Literal["left_foot", "right_foot", "left_hand", "right_hand"]
Task = Literal["contact", "reach"]
Phase = Literal[
    "starting",
    "hold",
    "approach",
    "touch",
    "load",
    "contact",
    "reach",
    "unload",
    "retreat",
    "held",
    "stopped",
]


class JointCommand(Message, frozen=True, kw_only=True):
    """Joint angles to be reached by the next tick."""

    tick: Stamp
    """The tick of the state that this command answers."""
    position: Array
    """(n,) in the order of the description [rad]"""

    def __post_init__(self) -> None:
        """Refuse NaN, infinity and wrong shapes: this moves a robot."""
        check_array("position", self.position, (None,))


class PlaceGoal(Message, frozen=True, kw_only=True):
    """Bring an end effector to a point on a surface, to touch it or to lean on it."""

    goal_id: Name
    end_effector: EndEffector
    task: Task
    point: Array
    """(3,) on the surface, in the world [m]"""
    normal: Array
    """(3,) of the surface, out of it, in the world"""
    effective_tick: int = -1
    """The tick at which the goal takes effect; -1 = as soon as it arrives."""
    force: float = 0.0
    """Normal force that a hand in contact pushes with [N]; 0 = its share, as balance finds best"""
    obstacles: HeightField | None = None
    """What the way must clear, as last seen; None: nothing is known of it"""

    def __post_init__(self) -> None:
        """Refuse NaN, a normal that has no direction, and points no robot could mean."""
        check_array("point", self.point, (3,))
        check_array("normal", self.normal, (3,))
        length = float(np.linalg.norm(self.normal))
        if length < 1e-6:
            raise ValueError(f"normal: length {length:g}, expected a direction (length 1)")
        if not 0.0 <= self.force < np.inf:
            raise ValueError(f"force: {self.force:g} N, expected 0 or more")
        distance = float(np.linalg.norm(self.point))
        if distance > 10.0:
            raise ValueError(f"point: {distance:.1f} m from the origin, limit 10 m; unit is metres")


class ReleaseGoal(Message, frozen=True, kw_only=True):
    """Take a hand off its support or out of its reach and bring it back; or lift a foot."""

    goal_id: Name
    end_effector: EndEffector
    effective_tick: int = -1


class GoalReply(Message, frozen=True, kw_only=True):
    """The controller took the goal. Progress follows as `GoalEvent` and `ControllerStatus`."""

    goal_id: Name
    start_tick: int
    posture_tick: int = -1
    """The tick whose desired posture the goal was judged and its way planned by; -1 = not said"""


class PreviewReply(Message, frozen=True, kw_only=True):
    """Whether a goal could be reached from here, found on the model without moving."""

    reachable: bool
    distance: float
    """What would be left between the end effector and where it should end: at the surface to touch
    it, 2 cm or more off it to reach [m]; -1 where it has no meaning"""
    reason: Text = ""
    """Why not; where it could, what to beware of"""


class GoalEvent(Message, frozen=True, kw_only=True):
    """A goal changed its state."""

    stamp_ns: Stamp
    goal_id: Name
    end_effector: EndEffector
    task: Task
    state: Literal[
        "accepted", "moving", "touched", "loaded", "reached", "unreachable", "released", "aborted"
    ]
    reason: Text = ""
    distance: float = -1.0
    """Between the end effector and where it should end (at the surface, or 2 cm or more off it to
    reach), by the model [m]; -1 where it has no meaning"""


class ControllerStatus(Message, frozen=True, kw_only=True):
    """What the controller does and how well it keeps time, published at 20 Hz."""

    stamp_ns: Stamp
    tick: Stamp
    phase: Phase
    goal_id: str = ""
    end_effector: str = ""
    task: str = ""
    distance: float = -1.0
    """What is left to the target, by the model [m]; -1 without a goal"""
    in_contact: tuple[bool, bool, bool, bool]
    """left foot, right foot, left hand, right hand"""
    desired_forces: Array
    """(4, 3) what the environment shall exert, in the world [N]"""
    end_effector_positions: Array
    """(4, 3) desired, in the world [m]"""
    loads: Array
    """(4,) normal force [N]: measured at feet and left wrist; the right hand's from torques"""
    solver_failures: int
    lateness_us: dict[str, float]
    """p50, p99, max of the last seconds [us]; gaps_20ms since the start [count]"""
    tick_us: dict[str, float]
    """p50, p99 of the time a tick takes [us]"""
    message: Text = ""
    """For the operator: why it holds, what it waits for"""
    soles: Array | None = None
    """(2, 7) left, right: position [m] and quaternion xyzw in the world, desired: where a process
    that starts later finds the world that this controller began with. None before it knows"""

    def __post_init__(self) -> None:
        """Refuse arrays of the wrong shape."""
        check_array("desired_forces", self.desired_forces, (4, 3))
        check_array("end_effector_positions", self.end_effector_positions, (4, 3))
        check_array("loads", self.loads, (4,))
        if self.soles is not None:
            check_array("soles", self.soles, (2, 7))


class StopRequest(Message, frozen=True, kw_only=True):
    """Hold still, now. Idempotent."""

    reason: Annotated[str, msgspec.Meta(max_length=1000)] = ""


class StopReply(Message, frozen=True, kw_only=True):
    """The robot holds. `mode` is the driver's mode after the request."""

    mode: Name
    stamp_ns: Stamp


SafetyCause = Literal[
    "sensor_not_finite",
    "sensor_frozen",
    "state_stale",
    "state_out_of_order",
    "position_limit",
    "velocity_limit",
    "torque_limit",
    "not_following",
    "command_jump",
    "command_not_finite",
    "command_not_taken",
    "qp_failed",
    "hand_overload",
    "contact_lost",
    "contact_slips",
    "contact_unexpected",
    "stopped",
    "no_snapshot",
]


class SafetyEvent(Message, frozen=True, kw_only=True):
    """Something that must not be: what was found, what the controller does, what a person may do.

    Published when it begins and when it ends.
    """

    stamp_ns: Stamp
    tick: Stamp
    cause: SafetyCause
    state: Literal["begins", "ends"]
    subject: Text = ""
    """Which joint, sensor or end effector"""
    value: float
    """What was found, in `unit`"""
    limit: float
    unit: Text = ""
    answer: Literal["pauses", "holds"]
    """pauses: the command waits, goals stay. holds: goals are aborted and the robot stands still.
    The motors stay on in both."""
    resumes: Literal["by itself", "after resume"]
    """by itself: the controller goes on once the cause is gone. after resume: an operator says."""
    text: Text
    """For the operator: what happened, and what to do"""


class QpStatistics(Message, frozen=True, kw_only=True):
    """How the quadratic programs of one kind fared since the controller started."""

    solved: int
    fallbacks: int
    """Solved by the second solver, after the first failed"""
    failures: int
    iterations_mean: float
    """Of the last report's period; -1 = the solver does not tell"""
    iterations_max: int
    active_rows: int
    """Constraints that hold with equality in the newest solution; -1 = the solver does not tell"""


class ControllerStatistics(Message, frozen=True, kw_only=True):
    """How the loop keeps time and how its programs fare, since its start; published at 2 Hz."""

    stamp_ns: Stamp
    tick: Stamp
    ticks: int
    """States that were answered"""
    missed_deadlines: int
    """Periods at whose end no state had come"""
    skipped_ticks: int
    """States that a newer one replaced before they were read"""
    old_states: int
    """States that were on their way for longer than the limit"""
    gaps_20ms: int
    """Intervals between two answers of more than 20 ms"""
    bin_edges_us: Array
    """(b,) upper edges of the bins of both histograms [us]; one more bin is above the last"""
    lateness_counts: Array
    """(b + 1,) answers by how late they began, after their state was due"""
    duration_counts: Array
    """(b + 1,) answers by how long they took"""
    lateness_max_us: float
    duration_max_us: float
    retargeting: QpStatistics
    force_control: QpStatistics
    collections: int
    """Runs of the garbage collector since the loop began: none is expected"""
    allocated_blocks: int
    """Of memory that Python objects hold"""
    memory_locked: bool
    real_time_priority: bool
    real_time: Text = ""
    """For people: what was not granted, and what grants it"""

    def __post_init__(self) -> None:
        """Refuse histograms of the wrong shape."""
        check_array("bin_edges_us", self.bin_edges_us, (None,))
        bins = self.bin_edges_us.shape[0] + 1
        for name in ("lateness_counts", "duration_counts"):
            check_array(name, getattr(self, name), (bins,), dtype=np.int64)


class ControllerSnapshot(Message, frozen=True, kw_only=True):
    """All that the controller needs to go on from a tick, bit by bit."""

    stamp_ns: Stamp
    tick: Stamp
    reason: Name
    """periodic, switch, request or hold"""
    robot_boot_id: Text
    """Of the robot whose ticks these are"""
    controller_boot_id: Text
    phase: Phase
    in_contact: tuple[bool, bool, bool, bool]
    """left foot, right foot, left hand, right hand"""
    command: Array
    """(n,) the answer to this tick [rad]"""
    state: dict[str, Any]
    """Part -> what changes in it from tick to tick: numbers, words and arrays, nested"""

    def __post_init__(self) -> None:
        """Refuse NaN, infinity and wrong shapes: a robot goes on from this."""
        check_array("command", self.command, (None,))


class ResumeReply(Message, frozen=True, kw_only=True):
    """What the controller does after it was told to go on."""

    holding: bool
    """True: it still holds, for the reason in `text`"""
    text: Text = ""
