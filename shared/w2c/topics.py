"""The one registry of what travels on the bus.

Keys are `w2c/v1/<robot>/<kind>/<service>/<name>`; calls are
`w2c/v1/<robot>/rpc/<service>/<instance>/<method>`.
The bus, the recorder, the health panel, the access-control file and the tables in the README
derive from it.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Generic, Literal, TypeVar

from w2c import messages as m
from w2c.errors import ConfigError

VERSION = "v1"

M_co = TypeVar("M_co", bound=m.Message, covariant=True)
Request = TypeVar("Request", bound=m.Message)
Reply = TypeVar("Reply", bound=m.Message)

Kind = Literal["state", "obs", "cmd", "goal", "event", "trace", "log", "health", "truth"]


class Priority(IntEnum):
    """Of a message on a shared link; lower is more urgent. The bus maps it to Zenoh's."""

    REAL_TIME = 1
    INTERACTIVE = 2
    DATA = 4
    DATA_LOW = 5


@dataclass(frozen=True)
class Topic(Generic[M_co]):
    """One row of the registry: a stream of messages."""

    kind: Kind
    service: str
    """Who writes it; `*` where every service writes its own."""
    name: str
    message: type[M_co]
    priority: Priority
    rate_hz: float
    """Nominal; 0 = when something happens."""
    readers: tuple[str, ...]
    recorded: bool = True
    drops: bool = True
    """True: a congested link drops, the newest matters. False: the writer waits."""
    max_bytes: int = 1_000_000
    lock_step: bool = False
    """True: in lock step this link blocks instead of dropping."""
    simulated: bool = False
    """True: only a simulator writes it, a real robot has none."""

    def key(self, robot: str, service: str | None = None) -> str:
        """Return the key expression, or the key of one writer of a `*` row."""
        return f"w2c/{VERSION}/{robot}/{self.kind}/{service or self.service}/{self.name}"


@dataclass(frozen=True)
class Method(Generic[Request, Reply]):
    """One row of the registry: a call that a service answers."""

    service: str
    name: str
    request: type[Request]
    reply: type[Reply]
    callers: tuple[str, ...]
    timeout_s: float = 5.0
    """Default deadline, wall time."""
    max_bytes: int = 1_000_000
    simulated: bool = False
    """True: only a simulator answers it, a real robot has none."""

    def key(self, robot: str, instance: str = "*") -> str:
        """Return the key of one replica, or of all of them."""
        return f"w2c/{VERSION}/{robot}/rpc/{self.service}/{instance}/{self.name}"


def liveliness_key(robot: str, service: str = "*", instance: str = "*") -> str:
    """Return the key of the liveliness token of a process."""
    return f"w2c/{VERSION}/{robot}/live/{service}/{instance}"


ALL = ("*",)
OPERATORS = ("console", "operator", "dialogue", "evaluation")

# --- streams
ROBOT_STATE = Topic(
    "state", "robot", "joints", m.RobotState, Priority.REAL_TIME, 500.0,
    ("controller", "perception", "console"), lock_step=True,
)  # fmt: skip
JOINT_COMMAND = Topic(
    "cmd",
    "controller",
    "joints",
    m.JointCommand,
    Priority.REAL_TIME,
    500.0,
    ("robot",),
    lock_step=True,
)
ROBOT_STATISTICS = Topic(
    "state", "robot", "statistics", m.RobotStatistics, Priority.DATA, 2.0,
    ("console", "operator", "evaluation"),
)  # fmt: skip
CAMERA_FRAME = Topic(
    "obs", "camera", "rgbd", m.CameraFrame, Priority.DATA_LOW, 3.0,
    ("perception", "dialogue", "console"), max_bytes=20_000_000,
)  # fmt: skip
CAMERA_VIEW = Topic(
    "state",
    "perception",
    "view",
    m.CameraView,
    Priority.DATA,
    3.0,
    ("console", "dialogue", "operator"),
    drops=False,
)
CONTROLLER_STATUS = Topic(
    "state", "controller", "status", m.ControllerStatus, Priority.DATA, 20.0,
    ("perception", "dialogue", "console", "operator", "evaluation"),
)  # fmt: skip
GOAL_EVENT = Topic(
    "event", "controller", "goal", m.GoalEvent, Priority.INTERACTIVE, 0.0,
    ("dialogue", "console", "operator", "evaluation"), drops=False,
)  # fmt: skip
SAFETY_EVENT = Topic(
    "event", "controller", "safety", m.SafetyEvent, Priority.INTERACTIVE, 0.0,
    ("dialogue", "console", "operator", "evaluation"), drops=False,
)  # fmt: skip
CONTROLLER_STATISTICS = Topic(
    "state", "controller", "statistics", m.ControllerStatistics, Priority.DATA, 2.0,
    ("console", "operator", "evaluation"),
)  # fmt: skip
CONTROLLER_SNAPSHOT = Topic(
    "state", "controller", "snapshot", m.ControllerSnapshot, Priority.DATA_LOW, 1.0,
    ("evaluation",),
)  # fmt: skip
TARGET = Topic(
    "state", "dialogue", "target", m.Target, Priority.INTERACTIVE, 0.0,
    ("console", "operator", "evaluation"), drops=False,
)  # fmt: skip
TURN = Topic(
    "event", "dialogue", "turn", m.Turn, Priority.INTERACTIVE, 0.0,
    ("console", "operator", "evaluation"), drops=False,
)  # fmt: skip
ADVICE = Topic(
    "state", "dialogue", "advice", m.Advice, Priority.INTERACTIVE, 0.0,
    ("console", "operator", "evaluation"), drops=False,
)  # fmt: skip
ALLOWED_AREA = Topic(
    "state", "dialogue", "allowed", m.AllowedArea, Priority.DATA, 0.0,
    ("console", "operator", "evaluation"), drops=False,
)  # fmt: skip
MARK = Topic("event", "recorder", "mark", m.MarkRequest, Priority.DATA, 0.0, (), drops=False)
RECORDER_STATUS = Topic(
    "state", "recorder", "status", m.RecorderStatus, Priority.DATA, 1.0, ("console", "operator")
)
PROCESS_TABLE = Topic(
    "state", "launcher", "processes", m.ProcessTable, Priority.DATA, 1.0, ("console", "operator")
)
HEALTH = Topic("health", "*", "status", m.Health, Priority.DATA, 1.0, ALL)
LOG = Topic("log", "*", "record", m.LogRecord, Priority.DATA, 0.0, ("console",), drops=False)
TRACE = Topic(
    "trace", "*", "call", m.CallTrace, Priority.DATA_LOW, 0.0, (), drops=False, max_bytes=40_000_000
)
TRUTH = Topic(
    "truth",
    "robot",
    "physics",
    m.Truth,
    Priority.DATA,
    100.0,
    ("camera", "evaluation"),
    simulated=True,
)

TOPICS: tuple[Topic[Any], ...] = (
    ROBOT_STATE, JOINT_COMMAND, ROBOT_STATISTICS, CAMERA_FRAME, CAMERA_VIEW,
    CONTROLLER_STATUS, GOAL_EVENT, SAFETY_EVENT, CONTROLLER_STATISTICS, CONTROLLER_SNAPSHOT,
    TARGET, TURN, ADVICE, ALLOWED_AREA,
    MARK, RECORDER_STATUS, PROCESS_TABLE, HEALTH, LOG, TRACE, TRUTH,
)  # fmt: skip

# --- calls
DESCRIBE = Method("robot", "describe", m.Empty, m.RobotDescription, ALL, max_bytes=4_000_000)
ROBOT_STOP = Method("robot", "stop", m.StopRequest, m.StopReply, ALL, timeout_s=2.0)
ROBOT_RESUME = Method("robot", "resume", m.Empty, m.StopReply, OPERATORS)
# With the rights of `truth`: the simulator and its judges.
PUSH = Method("robot", "push", m.PushRequest, m.PushReply, ("evaluation",), 2.0, simulated=True)
CAPTURE = Method(
    "camera",
    "capture",
    m.CaptureRequest,
    m.CameraFrame,
    ("dialogue", "console", "operator"),
    10.0,
    20_000_000,
)
PICTURE = Method(
    "camera",
    "picture",
    m.PictureRequest,
    m.Picture,
    ("evaluation", "operator"),
    20.0,
    20_000_000,
    simulated=True,
)
LIFT = Method("perception", "lift", m.LiftRequest, m.LiftReply, OPERATORS)
HEIGHT_FIELD = Method(
    "perception", "heights", m.HeightFieldRequest, m.HeightField, OPERATORS, timeout_s=2.0
)
POINT_CLOUD = Method(
    "perception", "cloud", m.PointCloudRequest, m.PointCloud, OPERATORS, max_bytes=4_000_000
)
FIND_ALLOWED_AREA = Method(
    "perception", "allowed", m.AllowedAreaRequest, m.AllowedArea, OPERATORS, timeout_s=2.0
)
PLACE = Method("controller", "place", m.PlaceGoal, m.GoalReply, OPERATORS)
RELEASE = Method("controller", "release", m.ReleaseGoal, m.GoalReply, OPERATORS)
CONTROLLER_STOP = Method("controller", "stop", m.StopRequest, m.StopReply, ALL, timeout_s=2.0)
CONTROLLER_RESUME = Method("controller", "resume", m.Empty, m.ResumeReply, OPERATORS, timeout_s=2.0)
SNAPSHOT = Method("controller", "snapshot", m.Empty, m.ControllerSnapshot, OPERATORS)
PREVIEW = Method("controller", "preview", m.PlaceGoal, m.PreviewReply, OPERATORS)
COMPLETE = Method("llm", "complete", m.CompleteRequest, m.CompleteReply, ALL, timeout_s=60.0)
CHOOSE = Method("llm", "choose", m.ChooseRequest, m.ChooseReply, ALL, timeout_s=60.0)
GROUND = Method("grounding", "ground", m.GroundingRequest, m.GroundingReply, ALL, 60.0, 40_000_000)
USE_MODEL = Method(
    "grounding", "use", m.UseModelRequest, m.UseModelReply,
    ("operator", "console", "evaluation"), timeout_s=600.0,
)  # fmt: skip
SAY = Method("dialogue", "say", m.SayRequest, m.Turn, ("console", "operator", "evaluation"), 120.0)
CONFIRM = Method(
    "dialogue", "confirm", m.ConfirmRequest, m.Turn, ("console", "operator", "evaluation"), 120.0
)
POINT = Method(
    "dialogue", "point", m.PointRequest, m.Turn, ("console", "operator", "evaluation"), 30.0
)
VETO = Method(
    "dialogue", "veto", m.VetoRequest, m.VetoReply, ("operator", "console", "evaluation"), 15.0
)
RECORD_START = Method("recorder", "start", m.RecordRequest, m.RecorderStatus, OPERATORS)
RECORD_STOP = Method("recorder", "stop", m.Empty, m.RecorderStatus, OPERATORS, timeout_s=30.0)
RECORD_STATUS = Method("recorder", "status", m.Empty, m.RecorderStatus, OPERATORS)
RECORD_MARK = Method("recorder", "mark", m.MarkRequest, m.RecorderStatus, OPERATORS)

METHODS: tuple[Method[Any, Any], ...] = (
    DESCRIBE, ROBOT_STOP, ROBOT_RESUME, PUSH, CAPTURE, PICTURE, LIFT, HEIGHT_FIELD,
    FIND_ALLOWED_AREA, POINT_CLOUD,
    PLACE, RELEASE, CONTROLLER_STOP,
    CONTROLLER_RESUME, SNAPSHOT, PREVIEW,
    COMPLETE, CHOOSE, GROUND, USE_MODEL, SAY, CONFIRM, POINT, VETO,
    RECORD_START, RECORD_STOP, RECORD_STATUS, RECORD_MARK,
)  # fmt: skip

SERVICES = (
    "robot", "camera", "controller", "perception", "grounding", "llm", "dialogue", "recorder",
    "console",
)  # fmt: skip
"""Every process of the running system, without router and launcher, in the order they start."""


def find_topic(kind: str, service: str, name: str) -> Topic[Any]:
    """Return the row that a key belongs to. Raises ConfigError for a key that no row describes."""
    for topic in TOPICS:
        if topic.kind == kind and topic.name == name and topic.service in ("*", service):
            return topic
    known = ", ".join(sorted(f"{topic.kind}/{topic.service}/{topic.name}" for topic in TOPICS))
    raise ConfigError(f"no topic {kind}/{service}/{name}; known: {known}")


def parse_key(key: str) -> tuple[str, Topic[Any], str]:
    """Split the key of a stream into robot, registry row and writer. Raises ConfigError."""
    parts = key.split("/")
    if len(parts) != 6 or parts[0] != "w2c" or parts[1] != VERSION:
        raise ConfigError(
            f"'{key}' is not a key of the form w2c/{VERSION}/<robot>/<kind>/<service>/<name>"
        )
    _, _, robot, kind, service, name = parts
    return robot, find_topic(kind, service, name), service
