"""A recorded session in the place of a robot."""

import threading
from pathlib import Path

import numpy as np
import pytest

from support.machines import (
    STATE_KEY,
    ScriptedClock,
    description_trace,
    raw_states,
    recorded_session,
    state_at,
)
from support.recordings import raw_mark, raw_message, write_recording
from w2c import topics
from w2c.bus import RawReceived
from w2c.bus.inprocess import InProcessHub
from w2c.driver import Driver
from w2c.errors import RecordingError
from w2c.messages import Empty, JointCommand, RobotState, StopRequest
from w2c_sim_robot.recorded.config import RecordedRobotConfig
from w2c_sim_robot.recorded.machine import RecordedRobot, open_recorded_robot
from w2c_sim_robot.recorded.session import Session, pack, read_session, unpack


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ticks 100 to 149; 110 to 112 are missing, 120 was sent twice."""
    path = tmp_path_factory.mktemp("recording") / "session.mcap"
    ticks = sorted([*(tick for tick in range(100, 150) if tick not in (110, 111, 112)), 120])
    write_recording(path, [raw_mark("begin"), *recorded_session(ticks)])
    return path


def played(robot: RecordedRobot, ticks: int) -> list[int]:
    """Return the recorded tick of each state, which its first angle tells."""
    seen = []
    for _ in range(ticks):
        state = robot.state(command_tick=-1, mode="holding")
        seen.append(round(float(state.position[0]) * 1e3))
        robot.step(robot.command, "holding")
    return seen


def test_packing_keeps_every_array() -> None:
    state = state_at(7, command=np.array([0.3, 0.4]))
    arrays = unpack(pack(state))
    names = {
        name for name in RobotState.__struct_fields__ if hasattr(getattr(state, name), "shape")
    }
    assert set(arrays) == names
    for name, array in arrays.items():
        assert array.tolist() == getattr(state, name).tolist(), name


def test_states_are_played_tick_by_tick_with_new_stamps(recording: Path) -> None:
    robot = RecordedRobot(read_session(recording))
    first = robot.state(command_tick=-1, mode="holding")
    assert (first.tick, first.stamp_ns) == (0, 0)
    assert played(robot, 15) == [*range(100, 110), 109, 109, 109, 113, 114]
    again = robot.state(command_tick=3, mode="tracking")
    assert (again.tick, again.stamp_ns) == (15, 30_000_000)
    assert (again.command_tick, again.mode) == (3, "tracking")
    assert again.velocity.tolist() == [0.5, 0.0]
    assert again.sole_wrenches.tolist() == np.arange(12.0).reshape(2, 6).tolist()


def test_at_the_end_it_stands_still_or_begins_again(recording: Path) -> None:
    session = read_session(recording, start_s=0.09)
    stays = RecordedRobot(session)
    assert played(stays, 8) == [145, 146, 147, 148, 149, 149, 149, 149]
    assert stays.state(command_tick=-1, mode="holding").velocity.tolist() == [0.0, 0.0]
    repeats = RecordedRobot(session, repeat=True)
    assert played(repeats, 8) == [145, 146, 147, 148, 149, 145, 146, 147]


def test_stopped_it_stands_still_and_goes_on_from_there(recording: Path) -> None:
    robot = RecordedRobot(read_session(recording))
    for mode in ("holding", "stopped", "stopped", "holding"):
        robot.step(robot.command, mode)
        if mode == "stopped":
            state = robot.state(command_tick=-1, mode="stopped")
            assert float(state.position[0]) == pytest.approx(0.101)
            assert state.velocity.tolist() == [0.0, 0.0]
            assert state.imu_angular_velocity.tolist() == [0.0, 0.0, 0.0]
    assert float(robot.state(command_tick=-1, mode="holding").position[0]) == pytest.approx(0.102)


def test_a_part_can_be_chosen(recording: Path) -> None:
    assert read_session(recording, start_s=0.01, duration_s=0.006).ticks == [105, 106, 107, 108]


def test_behind_a_driver_it_answers_obeys_stop_and_reports_commands(recording: Path) -> None:
    config = RecordedRobotConfig(robot="test", recording=str(recording), real_time="off")
    hub = InProcessHub()
    controller, operator = hub.connect("controller"), hub.connect("operator")
    states = controller.queue(topics.ROBOT_STATE)
    stop = threading.Event()
    seen: list[RobotState] = []

    def act(tick: int) -> None:
        received = states.receive(0.0)
        assert received is not None
        seen.append(received.message)
        if tick == 0:
            described = operator.call(topics.DESCRIBE, Empty()).message
            assert [joint.name for joint in described.joints] == ["hip", "rail"]
        if tick == 6:
            reply = operator.call(topics.ROBOT_STOP, StopRequest(reason="test")).message
            assert reply.mode == "stopped"
        angles = received.message.command + np.array([1e-4, 0.0])
        controller.publish(topics.JOINT_COMMAND, JointCommand(tick=tick, position=angles))
        if tick == 9:
            stop.set()

    bus = hub.connect("robot")
    driver = Driver(config, bus, ScriptedClock(act), lambda: open_recorded_robot(config))
    driver.configure()
    driver.run(stop)
    driver.close()
    bus.close()
    angles = [round(float(state.position[0]) * 1e3) for state in seen]
    assert angles == [100, 101, 102, 103, 104, 105, 106, 106, 106, 106]
    commanded = [round(float(state.command[0]) * 1e4) for state in seen]
    assert commanded == [0, 1, 2, 3, 4, 5, 6, 6, 6, 6]
    assert [state.mode for state in seen] == ["holding", *6 * ["tracking"], *3 * ["stopped"]]
    assert [state.command_tick for state in seen] == [-1, 0, 1, 2, 3, 4, 5, 5, 5, 5]


def test_a_file_that_was_never_closed_is_played_as_far_as_it_goes(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "open.mcap"
    write_recording(path, [description_trace(), *raw_states(range(5))], close=False)
    with path.open("ab") as file:
        file.write(b"\x05\xff\x00\x00")  # the beginning of a record that never came
    with caplog.at_level("WARNING"):
        assert read_session(path).ticks == [0, 1, 2, 3, 4]
    assert "played as far as it goes" in caplog.text


def test_the_first_run_of_a_robot_that_started_anew_is_played(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "twice.mcap"
    runs = [*raw_states(range(5)), *raw_states(range(9), boot="second")]
    write_recording(path, [description_trace(), *runs])
    assert read_session(path).ticks == [0, 1, 2, 3, 4]
    assert "started anew" in caplog.text


def refused(path: Path, **part: float) -> str:
    with pytest.raises(RecordingError) as error:
        read_session(path, **part)
    assert str(path) in str(error.value)
    return str(error.value)


def test_a_missing_or_foreign_file_is_refused(tmp_path: Path) -> None:
    assert "no recording" in refused(tmp_path / "none.mcap")
    foreign = tmp_path / "song.mcap"
    foreign.write_bytes(b"RIFF" + bytes(100))
    assert "MCAP" in refused(foreign)


def test_a_recording_without_states_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "quiet.mcap"
    write_recording(path, [raw_mark("nothing else"), description_trace()])
    assert "holds no states" in refused(path)


@pytest.mark.parametrize("others", [[], [description_trace("deadline")]])
def test_a_recording_without_a_description_is_refused(
    tmp_path: Path, others: list[RawReceived]
) -> None:
    path = tmp_path / "nameless.mcap"
    write_recording(path, [*others, *raw_states(range(3))])
    assert "no description" in refused(path)


def test_states_that_do_not_fit_the_description_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "odd.mcap"
    three = np.zeros(3)
    state = state_at(0, position=three, velocity=three, torque=three, command=three)
    write_recording(path, [description_trace(), raw_message(state, STATE_KEY, sender="robot")])
    assert "states of 3 joints, a description of 2" in refused(path)


def test_two_robots_in_one_recording_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "pair.mcap"
    other = raw_states(range(3), key=topics.ROBOT_STATE.key("other"))
    write_recording(path, [description_trace(), *raw_states(range(3)), *other])
    assert "two robots" in refused(path)


def test_a_part_beyond_the_end_or_beyond_memory_is_refused(
    recording: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "no state from 5 s on; its robot ran for 0.1 s" in refused(recording, start_s=5.0)
    monkeypatch.setattr("w2c_sim_robot.recorded.session.LONGEST_S", 0.05)
    assert "do not fit into memory" in refused(recording)
    assert isinstance(read_session(recording, duration_s=0.04), Session)
