"""What the page is told: the structs that become its JSON.

Stamps are strings there: JavaScript's numbers hold integers up to 2^53 only, and nanoseconds since
1970 are more.
"""

import msgspec


class Marker(msgspec.Struct, frozen=True):
    """The target as drawn on one picture."""

    target_id: str
    u: float
    v: float
    """Pixel of the picture it is drawn on"""
    state: str
    corrected: bool


class LabelledBox(msgspec.Struct, frozen=True):
    """The box of an object of the instruction, in pixels of the picture it is drawn on."""

    left: float
    top: float
    right: float
    bottom: float
    phrase: str


class PictureHeader(msgspec.Struct, frozen=True):
    """What is said of a picture; its JPEG follows unless the page has it already."""

    sequence: int
    """Of the picture, since the console started; 0: there is none yet"""
    stamp: str
    robot_boot: str
    """Of the robot in the picture: goes back with what is said about it; "" = not known"""
    width: int
    height: int
    age_s: float
    """Since this picture arrived [s]"""
    silent_s: float
    """Since the newest picture arrived [s]; the same unless the page is frozen"""
    limit_s: float
    """A longer silence is a fault [s]"""
    frozen: bool
    notice: str
    """Why there is no target on the picture, or why it does not move; for the operator"""
    marker: Marker | None
    destination: Marker | None
    """What the robot moves to, where the marker is another target. None, too: it is not seen"""
    moving_to: str
    """Its id; "" = the robot does not move, or to the marker"""
    boxes: list[LabelledBox]
    area: str
    """Stamp of the picture whose allowed area fits this one too; "-1": of none"""


class TargetPanel(msgspec.Struct, frozen=True):
    """What is known of the current target, besides where it is drawn."""

    target_id: str
    state: str
    instruction: str
    corrections: int
    warning: str


class ProcessRow(msgspec.Struct, frozen=True):
    """One process."""

    name: str
    instance: str
    phase: str
    level: str
    """good, busy, bad or absent: the colour of its lamp"""
    age_s: float | None
    """Since its last report [s]"""
    cpu_percent: float | None
    memory_mb: float | None
    restarts: int
    lost: int
    """Messages dropped or refused since it started"""
    late: int
    """How often its loop came late since it started; nothing was lost by it"""
    detail: str


class ContactRow(msgspec.Struct, frozen=True):
    """One end effector."""

    name: str
    in_contact: bool
    load: float
    """Normal force [N]"""
    desired_load: float
    """Norm of the desired force [N]"""


class ControllerPanel(msgspec.Struct, frozen=True):
    """What the controller says of itself."""

    age_s: float
    stale: bool
    phase: str
    message: str
    goal_id: str
    end_effector: str
    task: str
    distance: float
    solver_failures: int
    contacts: list[ContactRow]
    lateness_us: dict[str, float]
    tick_us: dict[str, float]


class RobotPanel(msgspec.Struct, frozen=True):
    """What the driver says of itself."""

    age_s: float
    stale: bool
    mode: str
    stamp: str


class RecorderPanel(msgspec.Struct, frozen=True):
    """What is being recorded."""

    age_s: float
    stale: bool
    recording: bool
    path: str
    messages: int
    bytes: int
    lost: int
    error: str


class Hello(msgspec.Struct, frozen=True, tag_field="type", tag="hello"):
    """The first thing said on a new connection."""

    boot: str
    """New at each start of the console: entry numbers begin again"""
    title: str
    robot: str


class Panel(msgspec.Struct, frozen=True, tag_field="type", tag="panel"):
    """The state of everything, twice a second."""

    robot: RobotPanel | None
    controller: ControllerPanel | None
    recorder: RecorderPanel | None
    target: TargetPanel | None
    processes: list[ProcessRow]


class TurnEntry(msgspec.Struct, frozen=True, tag_field="type", tag="turn"):
    """One exchange between operator and dialogue."""

    id: int
    """Number of the entry; 0 in the direct answer to a request"""
    key: str
    """The same for the entry and the direct answer, so that the page shows it once"""
    time_ms: int
    """Wall clock [ms since 1970]"""
    text: str
    reply: str
    ok: bool
    module: str
    options: list[str]
    """What may be answered where the reply is a question"""
    target_id: str
    seconds: float
    steps: dict[str, float]


class GoalEntry(msgspec.Struct, frozen=True, tag_field="type", tag="goal"):
    """A goal of the controller made progress."""

    id: int
    time_ms: int
    goal_id: str
    end_effector: str
    task: str
    state: str
    reason: str
    distance: float


class RemarkLine(msgspec.Struct, frozen=True):
    """One thing that was found out about a target."""

    kind: str
    level: str
    """fine, caution or veto"""
    text: str
    numbers: str
    """What was compared with what; "" where the text says it or there is nothing"""


class AdviceNews(msgspec.Struct, frozen=True, tag_field="type", tag="advice"):
    """What is known of a target besides its place; told as soon as it is known."""

    target_id: str
    refusal: str
    """Why it cannot be confirmed; "" = it can"""
    remarks: list[RemarkLine]
    """The most important first"""
    unchecked: list[str]
    """What could not be found out, and why"""
    pending: bool
    """There is more to come"""


class AreaNews(msgspec.Struct, frozen=True, tag_field="type", tag="area"):
    """Where in a picture a hand may go."""

    stamp: str
    """Of the picture"""
    rows: int
    columns: int
    bits: bytes
    """Row by row, eight cells a byte, the first in the highest bit; 1 = allowed. Base64 in JSON"""


Entry = TurnEntry | GoalEntry
