"""A small recorded session, written by hand: words, a correction, a yes, and a motion."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from support.recordings import raw_message, write_recording
from w2c import messages as m
from w2c import topics
from w2c.bus import Envelope, Input, RawReceived, encode_envelope
from w2c.bus.codec import ENVELOPE_VERSION

SECOND = 10**9
START_NS = 1_000 * SECOND
WIDTH, HEIGHT = 64, 48
FRAME_STAMP_NS = 5 * SECOND
LATER_STAMP_NS = 6 * SECOND


class Session:
    """Collects messages with their times and numbers; `write` makes the file."""

    def __init__(self) -> None:
        self.raw: list[RawReceived] = []
        self._numbers: dict[str, int] = {}

    def add(
        self,
        seconds: float,
        row: topics.Topic[Any],
        message: m.Message,
        inputs: Sequence[Input] = (),
        sender: str = "",
    ) -> Input:
        """Add a message that arrives at a time, and return the reference to it."""
        sender = sender or row.service
        key = row.key("test", sender)
        number = self._next(key)
        arrival = START_NS + round(seconds * SECOND)
        self.raw.append(
            raw_message(
                message, key, number, sender=sender, received_ns=arrival, inputs=inputs,
                boot_id=f"{sender}-boot",
            )
        )  # fmt: skip
        return Input(key=key, boot_id=f"{sender}-boot", sequence=number)

    def call(
        self,
        seconds: float,
        method: topics.Method[Any, Any],
        request: m.Message,
        reply: m.Message | None,
        *,
        caller: str = "dialogue",
        inputs: Sequence[Input] = (),
        duration_ms: float = 40.0,
        outcome: str = "ok",
    ) -> Input:
        """Add the trace of a call that ended at a time, and return the reference to the request."""
        key = method.key("test", "0")
        number = self._next(f"{caller} {key}")
        source = Input(key=key, boot_id=f"{caller}-boot", sequence=number)
        trace = m.CallTrace(
            service=method.service, method=method.name, instance="0", outcome=outcome,
            duration_ms=duration_ms, request=_wrapped(caller, number, request, inputs),
            reply=b"" if reply is None else _wrapped(method.service, number, reply, [source]),
            error="" if outcome == "ok" else "it failed",
        )  # fmt: skip
        self.add(seconds, topics.TRACE, trace, sender=caller)
        return source

    def write(self, path: Path, *, close: bool = True) -> Path:
        """Write the file in the order of arrival."""
        write_recording(path, sorted(self.raw, key=lambda raw: raw.received_ns), close=close)
        return path

    def _next(self, key: str) -> int:
        number = self._numbers.get(key, 0)
        self._numbers[key] = number + 1
        return number


def _wrapped(sender: str, number: int, message: m.Message, inputs: Sequence[Input]) -> bytes:
    return encode_envelope(
        Envelope(
            version=ENVELOPE_VERSION, robot="test", sender=sender, boot_id=f"{sender}-boot",
            sequence=number, monotonic_ns=0, clock_ns=0, inputs=list(inputs), data=message,
        )
    )  # fmt: skip


def frame(stamp_ns: int) -> m.CameraFrame:
    """Return a grey picture of a robot's time."""
    grey = np.full((HEIGHT, WIDTH, 3), 128, np.uint8)
    jpeg = cv2.imencode(".jpg", grey)[1].tobytes()
    return m.CameraFrame(
        stamp_ns=stamp_ns, frame="camera", width=WIDTH, height=HEIGHT,
        intrinsics=(50.0, 50.0, 32.0, 24.0), jpeg=jpeg, depth=b"",
    )  # fmt: skip


def target(number: int, u: float, *, state: str = "proposed", **more: Any) -> m.Target:
    """Return a target of the session."""
    return m.Target(
        target_id=f"target-{number}", u=u, v=24.0, state=state,  # type: ignore[arg-type]
        frame_stamp_ns=FRAME_STAMP_NS, point=np.array([0.5, -0.2, 0.8]),
        normal=np.array([0.0, 0.0, 1.0]), **more,
    )  # fmt: skip


def turn(text: str, module: str, shown: m.Target | None, **more: Any) -> m.Turn:
    """Return a turn of the session."""
    more = {"reply": "There?", "ok": True, "seconds": 0.3, **more}
    return m.Turn(stamp_ns=0, text=text, module=module, target=shown, **more)


def status(phase: str, goal_id: str = "", tick: int = 0) -> m.ControllerStatus:
    """Return a status of the controller."""
    return m.ControllerStatus(
        stamp_ns=0, tick=tick, phase=phase, goal_id=goal_id,  # type: ignore[arg-type]
        in_contact=(True, True, False, False), desired_forces=np.zeros((4, 3)),
        end_effector_positions=np.zeros((4, 3)), loads=np.zeros(4), solver_failures=0,
        lateness_us={}, tick_us={},
    )  # fmt: skip


def state(tick: int) -> m.RobotState:
    """Return the sensors of a robot with two joints."""
    two = np.array([0.1 * tick, -0.1])
    return m.RobotState(
        stamp_ns=tick * 2_000_000, tick=tick, position=two, velocity=two * 0, torque=two * 0,
        sole_wrenches=np.zeros((2, 6)), left_wrist_wrench=np.zeros(6),
        imu_orientation=np.array([0.0, 0.0, 0.0, 1.0]), imu_angular_velocity=np.zeros(3),
        imu_linear_acceleration=np.zeros(3), command=two, command_tick=tick - 1, mode="tracking",
    )  # fmt: skip


def conversation() -> Session:
    """Return: "on the book" at 1 s, "to the left" at 2 s, "yes" at 3 s, a motion from 3.1 s on."""
    session = Session()
    session.add(0.0, topics.CONTROLLER_STATUS, status("hold"))
    first = session.add(0.5, topics.CAMERA_FRAME, frame(FRAME_STAMP_NS))
    heat = np.zeros((6, 8), np.uint8)
    heat[2:4, 4:6] = 255
    box = m.Box(left=30.0, top=14.0, right=50.0, bottom=34.0, score=0.9)
    found = m.PhraseEvidence(
        phrase="book", found=True, score=0.9, point=(40.0, 24.0), boxes=[box], heatmap=heat
    )
    chat = [m.ChatMessage(role="user", content="on the book")]
    session.call(
        0.8, topics.CHOOSE,
        m.ChooseRequest(messages=chat, options=["prediction", "correction"]),
        m.ChooseReply(
            option="prediction", probabilities={"prediction": 0.99}, model="tiny",
            prompt_tokens=1, reused_tokens=0, queue_ms=0, prefill_ms=0,
        ),
    )  # fmt: skip
    session.call(
        0.9, topics.GROUND,
        m.GroundingRequest(jpeg=b"picture", phrases=["book"], want="heatmaps"),
        m.GroundingReply(model="seg", width=WIDTH, height=HEIGHT, evidence=[found], milliseconds=9),
        inputs=[first],
    )  # fmt: skip
    said = session.call(1.01, topics.SAY, m.SayRequest(text="on the book"), None, caller="console")
    proposed = target(1, 40.0, boxes=[box], phrases=["book"], instruction="on the book")
    session.add(1.0, topics.TURN, turn("on the book", "prediction.absolute", proposed), [said])
    session.add(1.5, topics.CAMERA_FRAME, frame(LATER_STAMP_NS))
    moved = session.call(
        2.01, topics.SAY, m.SayRequest(text="to the left", target_id="target-1"), None,
        caller="console",
    )  # fmt: skip
    corrected = target(2, 20.0, corrections=1, instruction="on the book")
    session.add(2.0, topics.TURN, turn("to the left", "correction", corrected), [moved])
    agreed = session.call(
        3.01, topics.CONFIRM, m.ConfirmRequest(target_id="target-2"), None, caller="console"
    )
    goal = m.PlaceGoal(
        goal_id="goal-3", end_effector="right_hand", task="contact",
        point=np.array([0.5, -0.2, 0.8]), normal=np.array([0.0, 0.0, 1.0]),
    )  # fmt: skip
    session.call(2.95, topics.PLACE, goal, m.GoalReply(goal_id="goal-3", start_tick=7))
    confirmed = target(2, 20.0, corrections=1, instruction="on the book", state="confirmed")
    session.add(
        3.0, topics.TURN,
        turn("", "confirmation", confirmed, goal_id="goal-3", end_effector="right_hand",
             task="contact", reply="I lean on it."),
        [agreed],
    )  # fmt: skip
    move(session)
    return session


def move(session: Session) -> None:
    """Add the motion: accepted at 3.1 s, reached at 4 s, states and commands all the while."""
    accepted = m.GoalEvent(
        stamp_ns=0, goal_id="goal-3", end_effector="right_hand", task="contact", state="accepted"
    )
    session.add(3.1, topics.GOAL_EVENT, accepted)
    session.add(3.2, topics.CONTROLLER_STATUS, status("approach", "goal-3"))
    for tick in range(10):
        seconds = 3.3 + 0.01 * tick
        source = session.add(seconds, topics.ROBOT_STATE, state(tick))
        command = m.JointCommand(tick=tick, position=np.array([0.1 * tick, -0.1]))
        session.add(seconds + 0.001, topics.JOINT_COMMAND, command, [source])
    loaded = m.GoalEvent(
        stamp_ns=0, goal_id="goal-3", end_effector="right_hand", task="contact", state="loaded",
        distance=0.004,
    )  # fmt: skip
    session.add(4.0, topics.GOAL_EVENT, loaded)
