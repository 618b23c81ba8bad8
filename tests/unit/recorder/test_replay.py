"""A recording on a bus once more: when, what, for whom, and never for a live robot."""

import threading
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import msgspec
import numpy as np
import pytest

from support.ports import free_endpoint
from support.recordings import MARK_KEY, raw_mark, raw_message, write_recording
from support.sessions import Session, conversation, target
from support.waiting import wait_until
from w2c import messages as m
from w2c import topics
from w2c.bus import InProcessBus, InProcessHub, RawReceived, decode_envelope
from w2c.bus.zenoh_bus import ZenohBus, connect
from w2c.clock import RealClock, StepClock
from w2c.config import ServiceConfig
from w2c.errors import ConfigError, ConnectionFailedError, RecordingError, RefusedError
from w2c.router import RouterConfig, open_router
from w2c_recorder.liveliness import Liveliness, key_of
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.reading import Recording
from w2c_recorder.replay.commands import replay
from w2c_recorder.replay.lateness import Lateness
from w2c_recorder.replay.options import ReplayOptions, parse_options
from w2c_recorder.replay.player import Player
from w2c_recorder.replay.prefetch import prefetched
from w2c_recorder.replay.run import play
from w2c_recorder.replay.score import Due
from w2c_recorder.report import Report
from w2c_recorder.through.options import ThroughOptions

HEALTH = m.Health(
    stamp_ns=0, service="llm", instance="1", phase="ready", pid=1, cpu_percent=0.0, memory_mb=1.0
)
SECOND = 10**9


class Desk:
    """A bus, a clock that needs no waiting, and all that is heard."""

    def __init__(self) -> None:
        self.hub = InProcessHub()
        self.clock = StepClock(SECOND)
        self.bus: InProcessBus = self.hub.connect("replay", robot="replay", instance="a")
        self.heard: list[RawReceived] = []
        self.times_ns: list[int] = []
        self.stop = threading.Event()
        self.on_message: Callable[[RawReceived], None] = lambda _raw: None
        self.hub.subscriptions.append((self, "w2c/v1/replay/**", self._hear))

    def play(self, path: Path, **options: object) -> Report:
        """Play a file and return the report."""
        chosen = msgspec.structs.replace(ReplayOptions(), **options)
        return play(Recording(path), chosen, self.bus, self.clock, self.stop, settle_s=0.0)

    def _hear(self, raw: RawReceived) -> None:
        self.heard.append(raw)
        self.times_ns.append(self.clock.now_ns())
        self.on_message(raw)

    @property
    def texts(self) -> list[str]:
        """Marks in the order in which they were heard."""
        return [
            decode_envelope(raw.payload).data["text"]
            for raw in self.heard
            if raw.key.endswith("/mark")
        ]


@pytest.fixture
def desk() -> Desk:
    return Desk()


@pytest.fixture
def marks(tmp_path: Path) -> Path:
    """Five marks, a second apart."""
    path = tmp_path / "session.mcap"
    write_recording(path, [raw_mark(str(n), n, (100 + n) * SECOND) for n in range(5)])
    return path


def test_messages_come_at_their_times(desk: Desk, marks: Path) -> None:
    desk.play(marks)

    assert desk.texts == ["0", "1", "2", "3", "4"]
    assert [time_ns - desk.times_ns[0] for time_ns in desk.times_ns] == [
        n * SECOND for n in range(5)
    ]
    assert {raw.key for raw in desk.heard} == {topics.MARK.key("replay")}


def test_speed_shortens_all_pauses(desk: Desk, marks: Path) -> None:
    desk.play(marks, speed=4.0)

    assert desk.times_ns[-1] - desk.times_ns[0] == SECOND


def test_a_late_message_does_not_delay_the_next(desk: Desk, marks: Path) -> None:
    def slow(raw: RawReceived) -> None:
        if decode_envelope(raw.payload).sequence == 1:
            desk.clock.set(desk.clock.now_ns() + SECOND * 3 // 2)

    desk.on_message = slow
    report = desk.play(marks)

    since = [time_ns - desk.times_ns[0] for time_ns in desk.times_ns]
    assert since == [0, SECOND, SECOND * 5 // 2, 3 * SECOND, 4 * SECOND]
    assert report.values["late_ms"] == {"p50": 0.0, "p99": 0.0, "max": 500.0}
    assert "sent late: p50 0.00, p99 0.00, max 500.00 ms" in report.lines


def test_a_part_is_played_by_the_times_of_the_timeline(desk: Desk, marks: Path) -> None:
    desk.play(marks, start_s=1.0, end_s=3.0)

    assert desk.texts == ["1", "2"]


@pytest.mark.parametrize("close", [True, False], ids=["by its index", "without one"])
def test_a_part_begins_with_what_held_then(desk: Desk, tmp_path: Path, close: bool) -> None:
    def note(instance: str, alive: bool, second: int) -> RawReceived:
        change = Liveliness(service="llm", instance=instance, alive=alive)
        return raw_message(change, key_of("test", change), second, received_ns=second * SECOND)

    def shown(number: int, second: int) -> RawReceived:
        key = topics.TARGET.key("test")
        return raw_message(target(number, 5.0), key, number, received_ns=second * SECOND)

    path = tmp_path / "session.mcap"
    file = McapFile(path, {})
    for chunk in (
        [raw_mark("a", 0, SECOND)],
        [note("0", True, 2), note("1", True, 2), shown(1, 3)],
        [note("0", False, 4), shown(2, 4)],
        [raw_mark("b", 1, 5 * SECOND), shown(3, 8), raw_mark("c", 2, 9 * SECOND)],
    ):
        for message in chunk:
            file.write(message, message.received_ns)
        file.flush()
    if close:
        file.close()
    else:
        file.abandon()
    seen: list[list[tuple[str, str]]] = []
    desk.on_message = lambda _raw: seen.append([one for one in desk.bus.alive() if one[0] == "llm"])

    desk.play(path, start_s=6.0)

    said = [decode_envelope(raw.payload).data for raw in desk.heard]
    assert [one.get("target_id", one.get("text")) for one in said] == ["target-2", "target-3", "c"]
    assert [time_ns - desk.times_ns[0] for time_ns in desk.times_ns] == [0, SECOND, 2 * SECOND]
    assert seen[0] == [("llm", "1")]

    desk.heard.clear()
    desk.play(path, start_s=6.0, exclude=("state/dialogue/*",))
    assert names(desk.heard) == {"event/recorder/mark"}


def test_a_loop_begins_again_as_after_a_new_start(desk: Desk, marks: Path) -> None:
    def enough(_raw: RawReceived) -> None:
        if len(desk.heard) == 12:
            desk.stop.set()
            desk.clock.set(desk.clock.now_ns() + SECOND)

    desk.on_message = enough
    report = desk.play(marks, loop=True)

    assert desk.texts == ["0", "1", "2", "3", "4"] * 2 + ["0", "1"]
    boots = [decode_envelope(raw.payload).boot_id for raw in desk.heard]
    assert len(set(boots)) == 3
    assert len(set(boots[:5])) == 1
    assert "in 2 passes" in report.lines[0]


def test_a_pause_can_be_ended(desk: Desk, tmp_path: Path) -> None:
    path = tmp_path / "session.mcap"
    write_recording(path, [raw_mark("a", 0, 0), raw_mark("b", 1, 3600 * SECOND)])
    desk.on_message = lambda _raw: desk.stop.set()

    desk.play(path)

    assert desk.texts == ["a"]
    assert desk.clock.now_ns() < 2 * SECOND


def names(heard: Iterable[RawReceived]) -> set[str]:
    return {raw.key.split("/", 3)[-1] for raw in heard}


def test_keys_are_chosen_by_patterns_of_the_registry(desk: Desk, session_file: Path) -> None:
    desk.play(session_file, include=("state/*", "event/dialogue/*"), exclude=("*/joints",))

    assert names(desk.heard) == {"state/controller/status", "event/dialogue/turn"}


def test_commands_are_played_when_asked_only(desk: Desk, session_file: Path) -> None:
    desk.play(session_file)
    assert "cmd/controller/joints" not in names(desk.heard)
    assert "state/robot/joints" in names(desk.heard)

    desk.heard.clear()
    desk.play(session_file, with_commands=True)
    assert "cmd/controller/joints" in names(desk.heard)


def test_calls_are_told_and_not_made(desk: Desk, session_file: Path) -> None:
    asked: list[m.SayRequest] = []

    def answer(request: m.SayRequest, _context: object) -> m.Turn:
        asked.append(request)
        raise RefusedError("nothing is said here")

    for robot in ("replay", "test"):
        desk.hub.connect("dialogue", robot=robot).serve(topics.SAY, answer)

    desk.play(session_file, with_commands=True)

    assert {"trace/console/call", "trace/dialogue/call"} <= names(desk.heard)
    assert not asked


@pytest.mark.parametrize("service", ["robot", "controller"])
@pytest.mark.parametrize("with_commands", [True, False])
def test_a_live_robot_is_never_played_at(
    desk: Desk, marks: Path, service: str, with_commands: bool
) -> None:
    desk.hub.connect(service, robot="replay")

    with pytest.raises(RefusedError, match=f"a {service} lives as 'replay'.*--as"):
        desk.play(marks, with_commands=with_commands)
    assert not desk.heard


def test_a_robot_elsewhere_is_in_nobodys_way(desk: Desk, marks: Path) -> None:
    desk.hub.connect("robot", robot="talos")

    desk.play(marks)

    assert len(desk.heard) == 5


def test_two_replays_do_not_share_a_name(desk: Desk, marks: Path) -> None:
    desk.hub.connect("replay", robot="replay", instance="b")

    with pytest.raises(RefusedError, match="another replay plays as 'replay'"):
        desk.play(marks)


def test_a_robot_that_comes_meanwhile_ends_the_replay(desk: Desk, tmp_path: Path) -> None:
    session = Session()
    own = msgspec.structs.replace(HEALTH, service="robot", instance="0")
    for second in range(5):
        session.add(second, topics.HEALTH, own, sender="robot")
    path = session.write(tmp_path / "session.mcap")
    live = desk.hub.connect("robot", robot="replay", instance="9")
    live.disappear("robot", "9")

    def come(_raw: RawReceived) -> None:
        desk.on_message = lambda _raw: None
        live.publish(topics.HEALTH, own)

    desk.on_message = come
    with pytest.raises(RefusedError, match="a robot lives as 'replay'"):
        desk.play(path)
    assert len(desk.heard) == 2
    assert ("robot", "0") not in desk.bus.alive()


def test_processes_are_seen_while_they_were_there(desk: Desk, tmp_path: Path) -> None:
    def note(instance: str, alive: bool, sequence: int, second: int) -> RawReceived:
        change = Liveliness(service="llm", instance=instance, alive=alive)
        key = key_of("test", change)
        return raw_message(change, key, sequence, received_ns=second * SECOND)

    path = tmp_path / "session.mcap"
    health_key = topics.HEALTH.key("test", "llm")
    write_recording(
        path,
        [note("0", True, 0, 1), raw_mark("a", 0, 2 * SECOND),
         raw_message(HEALTH, health_key, received_ns=3 * SECOND), raw_mark("b", 1, 4 * SECOND),
         note("0", False, 1, 5), raw_mark("c", 2, 6 * SECOND)],
    )  # fmt: skip
    seen: list[list[tuple[str, str]]] = []

    def look(raw: RawReceived) -> None:
        if raw.key.endswith("/mark"):
            seen.append([one for one in desk.bus.alive() if one[0] == "llm"])

    desk.on_message = look
    desk.play(path)
    assert seen == [[("llm", "0")], [("llm", "0"), ("llm", "1")], [("llm", "1")]]
    assert desk.bus.alive() == [("replay", "a")]

    seen.clear()
    desk.play(path, exclude=("health/llm/*",))
    assert seen == [[], [], []]


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"include": ("state/*",)}, r"fits --include state/\*.*It holds: event/recorder/mark"),
        ({"exclude": ("event/*/*",)}, r"--exclude event/\*/\*.*It holds: event/recorder/mark"),
        ({"start_s": 7.0}, "no message from 7 s to its end; it is 4.0 s long"),
        ({"start_s": 1.2, "end_s": 1.8}, "no message from 1.2 s to 1.8 s; it is 4.0 s long"),
    ],
    ids=["include", "exclude", "late", "between"],
)
def test_nothing_to_play_is_an_error_that_says_what_there_is(
    desk: Desk, marks: Path, options: dict[str, object], problem: str
) -> None:
    with pytest.raises(RecordingError, match=problem):
        desk.play(marks, **options)


def test_a_recording_of_commands_alone_names_the_flag(desk: Desk, tmp_path: Path) -> None:
    path = tmp_path / "session.mcap"
    command = m.JointCommand(tick=0, position=np.zeros(2))
    write_recording(path, [raw_message(command, topics.JOINT_COMMAND.key("test"))])

    with pytest.raises(RecordingError, match="commands are played --with-commands only"):
        desk.play(path)


def test_of_a_damaged_file_what_is_there_is_played(desk: Desk, tmp_path: Path) -> None:
    path = conversation().write(tmp_path / "a.mcap", close=False)
    path.write_bytes(path.read_bytes() + b"\x05\xff")

    report = desk.play(path)

    assert "event/dialogue/turn" in names(desk.heard)
    assert any("not closed" in line for line in report.lines)


def test_a_file_without_a_message_is_an_error(desk: Desk, tmp_path: Path) -> None:
    path = tmp_path / "session.mcap"
    path.write_bytes(b"\x89MCAP0\r\n")

    with pytest.raises(RecordingError, match="holds no message of this version: ends in the"):
        desk.play(path)


def test_messages_that_this_version_does_not_know_are_played_or_told(
    desk: Desk, tmp_path: Path
) -> None:
    path = tmp_path / "session.mcap"
    unknown = "w2c/v1/test/state/nobody/knows"
    write_recording(
        path,
        [raw_message(m.MarkRequest(text="a"), unknown, received_ns=1),
         RawReceived(MARK_KEY, b"garbage", 2), RawReceived("w2c/v2/test/odd/one/out", b"\x80", 3)],
    )  # fmt: skip

    report = desk.play(path)

    assert names(desk.heard) == {"state/nobody/knows"}
    assert f"left out: 1 messages of {MARK_KEY}, which are none of this version" in report.lines


def test_a_recording_of_another_version_says_so(desk: Desk, tmp_path: Path) -> None:
    path = tmp_path / "session.mcap"
    write_recording(path, [RawReceived("w2c/v2/test/odd/one/out", b"\x80", 3)])

    with pytest.raises(RecordingError, match="no message of this version: w2c/v2/test/odd"):
        desk.play(path)


def test_a_defect_while_reading_comes_out(desk: Desk) -> None:
    def breaks() -> Iterator[Due]:
        yield Due(0, topics.MARK.key("replay"), b"x")
        raise RecordingError("the disk is gone")

    player = Player(desk.bus, desk.clock)
    with pytest.raises(RecordingError, match="the disk is gone"), prefetched(breaks()) as dues:
        player.play(dues)
    assert player.played.messages == 1


def test_who_reads_ahead_ends_with_who_plays() -> None:
    def endless() -> Iterator[Due]:
        while True:
            yield Due(0, "key", b"x" * 100_000)

    before = threading.active_count()
    with prefetched(endless()) as dues:
        next(dues)
        assert threading.active_count() == before + 1
    assert threading.active_count() == before


def test_lateness_keeps_the_worst_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("w2c_recorder.replay.lateness.KEPT", 2048)
    lateness = Lateness()
    lateness.add(9_000_000)
    for _ in range(5000):
        lateness.add(1_000_000)

    assert lateness.values_ms() == {"p50": 1.0, "p99": 1.0, "max": 9.0}


def test_flags_become_options() -> None:
    path, options = parse_options(
        ["a.mcap", "--from", "1:02.5", "--until", "70", "--as", "desk", "--speed", "2", "--loop",
         "--include", "state/*", "--include", "log/*", "--exclude", "*/robot/*",
         "--with-commands"]
    )  # fmt: skip

    assert path == Path("a.mcap")
    assert options == ReplayOptions(
        namespace="desk", speed=2.0, start_s=62.5, end_s=70.0, loop=True,
        include=("state/*", "log/*"), exclude=("*/robot/*",), with_commands=True,
    )  # fmt: skip


def test_a_service_is_run_by_another_part() -> None:
    options = parse_options(["a.mcap", "--through", "controller", "--until", "3"])[1]

    assert options == ThroughOptions(service="controller", end_s=3.0)


@pytest.mark.parametrize(
    ("flags", "problem"),
    [
        (["--as", "Talos 1"], "namespace"),
        (["--speed", "0"], "speed"),
        (["--from", "5", "--until", "5"], "--until 5 is not after --from 5"),
        (["--tolerance", "1"], "--tolerance goes with --through"),
        (["--through", "llm", "--tolerance", "-1"], "--tolerance -1: .* 0 or more"),
        (["--through", "llm", "--tolerance", "nan"], "--tolerance nan: .* 0 or more"),
        (["--through", "llm", "--from", "5", "--until", "3"], "--until 3 is not after --from 5"),
        (["--through", "llm", "--as", "desk"], "--as is for a replay on the bus"),
        (["--through", "llm", "--with-commands"], "--with-commands is for a replay on the bus"),
    ],
)
def test_flags_that_make_no_sense_are_refused(flags: list[str], problem: str) -> None:
    with pytest.raises(ConfigError, match=problem):
        parse_options(["a.mcap", *flags])


@pytest.mark.parametrize(
    ("content", "problem"),
    [(b"these are notes", "not an MCAP file"), (b"", "is empty"), (None, "no recording at")],
    ids=["foreign", "empty", "missing"],
)
def test_a_file_that_is_none_is_told_before_a_bus_is_looked_for(
    tmp_path: Path, content: bytes | None, problem: str
) -> None:
    path = tmp_path / "session.mcap"
    if content is not None:
        path.write_bytes(content)

    with pytest.raises(RecordingError, match=problem):
        replay([str(path)])


def test_where_nothing_runs_the_router_can_be_named(
    marks: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    with pytest.raises(ConnectionFailedError, match="--router ENDPOINT"):
        replay([str(marks)])


def test_over_a_router_all_arrive_in_order_and_a_live_robot_is_seen(tmp_path: Path) -> None:
    path = tmp_path / "session.mcap"
    write_recording(path, [raw_mark(str(n), n, n * 1_000_000) for n in range(200)])
    endpoint = free_endpoint()
    config = ServiceConfig(robot="replay", router=endpoint, connect_timeout=5.0)

    def connected(service: str) -> ZenohBus:
        return connect(config, service, [endpoint])

    with (
        open_router(RouterConfig(listen=endpoint)),
        connected("replay") as bus,
        connected("operator") as operator,
    ):
        marks = operator.queue(topics.MARK)
        options, stop = ReplayOptions(), threading.Event()
        wait_until(lambda: ("operator", "0") in bus.alive())
        report = play(Recording(path), options, bus, RealClock(), stop, settle_s=0.2)
        heard = [marks.receive(5.0) for _ in range(200)]
        assert [one.message.text for one in heard if one is not None] == [
            str(n) for n in range(200)
        ]
        assert report.values["messages"] == 200

        with connected("robot"), pytest.raises(RefusedError, match="a robot lives as 'replay'"):
            play(Recording(path), options, bus, RealClock(), stop, settle_s=5.0)
        assert marks.receive(0.0) is None
