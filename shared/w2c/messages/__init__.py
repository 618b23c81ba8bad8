"""Every message of the system, one frozen struct each. Units and frames stand in the docstrings.

World: origin on the floor midway between the soles when the controller starts, x forward, z up.
Metres, radians, newtons, seconds; stamps are integer nanoseconds of robot time. Quaternions are
xyzw.
Wrenches are force then torque, what the environment exerts on the robot. Pixels are (u right, v
down).
"""

from w2c.messages.base import (
    Array,
    CallTrace,
    Empty,
    ErrorReply,
    Health,
    LogRecord,
    Message,
    ProcessState,
    ProcessTable,
    check_array,
)
from w2c.messages.control import (
    ControllerStatus,
    EndEffector,
    GoalEvent,
    GoalReply,
    JointCommand,
    PlaceGoal,
    PreviewReply,
    ReleaseGoal,
    StopReply,
    StopRequest,
    Task,
)
from w2c.messages.conversation import (
    ConfirmRequest,
    PointRequest,
    SayRequest,
    Target,
    Turn,
)
from w2c.messages.models import (
    Box,
    ChatMessage,
    ChooseReply,
    ChooseRequest,
    CompleteReply,
    CompleteRequest,
    GroundingReply,
    GroundingRequest,
    PhraseEvidence,
)
from w2c.messages.recording import MarkRequest, RecorderStatus, RecordRequest
from w2c.messages.robot import (
    CameraFrame,
    CaptureRequest,
    JointInfo,
    Picture,
    PictureRequest,
    RobotDescription,
    RobotState,
    Truth,
)
from w2c.messages.view import (
    CameraView,
    LiftReply,
    LiftRequest,
)

__all__ = [
    "Array",
    "Box",
    "CallTrace",
    "CameraFrame",
    "CameraView",
    "CaptureRequest",
    "ChatMessage",
    "ChooseReply",
    "ChooseRequest",
    "CompleteReply",
    "CompleteRequest",
    "ConfirmRequest",
    "ControllerStatus",
    "Empty",
    "EndEffector",
    "ErrorReply",
    "GoalEvent",
    "GoalReply",
    "GroundingReply",
    "GroundingRequest",
    "Health",
    "JointCommand",
    "JointInfo",
    "LiftReply",
    "LiftRequest",
    "LogRecord",
    "MarkRequest",
    "Message",
    "PhraseEvidence",
    "Picture",
    "PictureRequest",
    "PlaceGoal",
    "PointRequest",
    "PreviewReply",
    "ProcessState",
    "ProcessTable",
    "RecordRequest",
    "RecorderStatus",
    "ReleaseGoal",
    "RobotDescription",
    "RobotState",
    "SayRequest",
    "StopReply",
    "StopRequest",
    "Target",
    "Task",
    "Truth",
    "Turn",
    "check_array",
]
