"""One example of every message, with every field set."""

import numpy as np
from w2c import messages as m

JOINTS = 3


def all_examples() -> dict[str, m.Message]:
    """Return type name -> example."""
    box = m.Box(left=1.0, top=2.0, right=30.0, bottom=40.0, score=0.75)
    chat = [
        m.ChatMessage(role="system", content="select"),
        m.ChatMessage(role="user", content="hi"),
    ]
    target = m.Target(
        target_id="t-1", frame_stamp_ns=5, u=640.5, v=360.5, point=np.array([0.5, -0.2, 0.8]),
        normal=np.array([0.0, 0.0, 1.0]), state="proposed", corrections=1, instruction="on the book",
        boxes=[box], phrases=["book"], warning="near an edge",
    )  # fmt: skip
    joints = [
        m.JointInfo(name=f"joint_{i}", stiffness=5000.0, effort_limit=100.0) for i in range(JOINTS)
    ]
    vector = np.arange(3.0)
    examples: list[m.Message] = [
        m.Empty(),
        m.ErrorReply(code="refused", message="no", retryable=True),
        m.Health(
            stamp_ns=1, service="llm", instance="0", phase="ready", detail="", pid=2, cpu_percent=3.0,
            memory_mb=4.0, queue_length=5, counters={"malformed x": 6},
        ),
        m.LogRecord(stamp_ns=1, level="info", logger="w2c", text="text", fields={"a": "b"}),
        m.CallTrace(
            service="llm", method="choose", instance="0", outcome="ok", duration_ms=1.5,
            request=b"q", reply=b"r", error="",
        ),
        m.ProcessState(name="llm", phase="ready", pid=1, restarts=0, detail=""),
        m.ProcessTable(
            stamp_ns=1, run_directory="runs/x",
            processes=[m.ProcessState(name="llm", phase="failed", pid=None, restarts=2)],
        ),
        joints[0],
        m.RobotDescription(
            urdf="<robot/>", joints=joints, sole_frames=("left", "right"), hand_frames=("left", "right"),
            hand_radius=(0.0, 0.05), camera_frame="camera", initial_position=vector,
            period_ns=2_000_000, lock_step=False,
        ),
        m.RobotState(
            stamp_ns=1, tick=2, position=vector, velocity=vector, torque=vector,
            sole_wrenches=np.ones((2, 6)), left_wrist_wrench=np.ones(6),
            imu_orientation=np.array([0.0, 0.0, 0.0, 1.0]), imu_angular_velocity=vector,
            imu_linear_acceleration=vector, command=vector, command_tick=-1, mode="tracking",
        ),
        m.CameraFrame(
            stamp_ns=1, frame="camera", width=1280, height=720, intrinsics=(1.0, 1.0, 640.0, 360.0),
            jpeg=b"jpeg", depth=b"zstd", depth_unit=0.00025,
        ),
        m.CaptureRequest(shadows=True, antialiasing=True),
        m.PictureRequest(view="front", width=64, height=48),
        m.Picture(stamp_ns=1, jpeg=b"jpeg"),
        m.Truth(
            stamp_ns=1, tick=2, generalized_position=vector, world_from_base=np.arange(7.0),
            end_effector_positions=np.ones((4, 3)), contact_forces=np.ones((4, 3)), fell=False,
            scene={"cup": (1.0, 2.0, 3.0)}, description="a",
        ),
        m.JointCommand(tick=1, position=vector),
        m.PlaceGoal(
            goal_id="g", end_effector="right_hand", task="contact", point=vector,
            normal=np.array([0.0, 0.0, 1.0]), effective_tick=7,
        ),
        m.ReleaseGoal(goal_id="g", end_effector="left_hand", effective_tick=-1),
        m.GoalReply(goal_id="g", start_tick=3),
        m.PreviewReply(reachable=False, distance=0.1, reason="too far"),
        m.GoalEvent(
            stamp_ns=1, goal_id="g", end_effector="right_hand", task="contact", state="loaded",
            reason="", distance=0.01,
        ),
        m.ControllerStatus(
            stamp_ns=1, tick=2, phase="hold", goal_id="g", end_effector="right_hand", task="contact",
            distance=0.1, in_contact=(True, True, False, False), desired_forces=np.ones((4, 3)),
            end_effector_positions=np.ones((4, 3)), loads=np.ones(4), solver_failures=0,
            lateness_us={"p50": 1.0}, tick_us={"p50": 2.0}, message="",
        ),
        m.StopRequest(reason="operator"),
        m.StopReply(mode="stopped", stamp_ns=1),
        chat[0],
        m.CompleteRequest(
            messages=chat, schema={"type": "object"}, seed=1, temperature=0.5, max_tokens=10,
            constant_messages=1,
        ),
        m.CompleteReply(
            text="{}", value={}, model="m", prompt_tokens=1, reused_tokens=2, completion_tokens=3,
            queue_ms=0.1, prefill_ms=0.2, decode_ms=0.3,
        ),
        m.ChooseRequest(messages=chat, options=["a", "b"], log_prior={"a": 0.1}, constant_messages=1),
        m.ChooseReply(
            option="a", probabilities={"a": 0.9, "b": 0.1}, model="m", prompt_tokens=1,
            reused_tokens=1, queue_ms=0.0, prefill_ms=0.0,
        ),
        m.GroundingRequest(jpeg=b"jpeg", phrases=["book"], want="heatmaps"),
        box,
        m.PhraseEvidence(
            phrase="book", found=True, score=0.9, point=(1.0, 2.0), boxes=[box],
            heatmap=np.zeros((2, 3), np.uint8), unknown_words=["violin"],
        ),
        m.GroundingReply(
            model="m", width=4, height=5, milliseconds=6.0,
            evidence=[m.PhraseEvidence(phrase="x", found=False, score=0.0, point=None, boxes=[])],
        ),
        m.CameraView(
            stamp_ns=1, world_from_camera=np.eye(4), intrinsics=(1.0, 1.0, 2.0, 2.0), width=4, height=4
        ),
        m.LiftRequest(u=1.5, v=2.5, frame_stamp_ns=3, footprint=0.03),
        m.LiftReply(
            point=vector, normal=vector, error_bound=0.001, flatness=0.0, slope=0.1, extent=0.05,
            frame_stamp_ns=1, warning="",
        ),
        target,
        m.SayRequest(text="yes", frame_stamp_ns=1, target_id="t-1"),
        m.ConfirmRequest(target_id="t-1"),
        m.PointRequest(u=1.0, v=2.0, frame_stamp_ns=-1, end_effector="left_hand", task="reach"),
        m.Turn(
            stamp_ns=1, text="yes", module="confirmation", reply="ok", ok=True, target=target,
            goal_id="g", end_effector="right_hand", task="contact", seconds=0.2, steps={"selector": 0.1},
        ),
        m.RecordRequest(path="x.mcap"),
        m.MarkRequest(text="here"),
        m.RecorderStatus(
            stamp_ns=1, recording=True, path="x.mcap", messages=1, bytes=2, lost={"k": 3}, error=""
        ),
    ]  # fmt: skip
    return {type(example).__name__: example for example in examples}
