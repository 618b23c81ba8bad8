"""Both buses keep the same promises."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import msgspec
import numpy as np
import pytest
import zenoh

from support.ports import free_endpoint
from support.recordings import raw_message
from support.waiting import wait_until
from w2c import topics
from w2c.bus import Bus, CallContext, InProcessBus, InProcessHub, zenoh_bus
from w2c.bus.zenoh_bus import ZenohBus, connect
from w2c.config import ServiceConfig
from w2c.errors import (
    ConnectionFailedError,
    DeadlineError,
    GoalRefusedError,
    MessageError,
    RefusedError,
    RemoteError,
    UnavailableError,
)
from w2c.messages import Empty, JointCommand, MarkRequest, RecorderStatus, StopReply, StopRequest
from w2c.router import RouterConfig, open_router

Connect = Callable[[str], Bus]


@pytest.fixture(params=["in process", "zenoh"])
def connect_bus(request: pytest.FixtureRequest) -> Iterator[Connect]:
    """Give a function that connects a service to a fresh, private bus."""
    with ExitStack() as stack:
        if request.param == "in process":
            hub = InProcessHub()

            def connect_one(service: str) -> Bus:
                return stack.enter_context(hub.connect(service))
        else:
            endpoint = free_endpoint()
            stack.enter_context(open_router(RouterConfig(listen=endpoint)))
            config = ServiceConfig(robot="test", router=endpoint, connect_timeout=5.0)

            def connect_one(service: str) -> Bus:
                return stack.enter_context(connect(config, service, [endpoint]))

        yield connect_one


def command(tick: int) -> JointCommand:
    return JointCommand(tick=tick, position=np.arange(3.0))


def publish_until_received(bus: Bus, tick: int, take: Callable[[], object]) -> None:
    """Publish until the subscriber gets one: a subscription takes a moment to reach the router."""

    def attempt() -> bool:
        bus.publish(topics.JOINT_COMMAND, command(tick))
        return take() is not None

    wait_until(attempt)


def test_a_queue_gets_every_message_in_order_with_its_envelope(connect_bus: Connect) -> None:
    """Sequence numbers count per key; the boot id tells one life of the sender from the next."""
    controller, robot = connect_bus("controller"), connect_bus("robot")
    queue = robot.queue(topics.JOINT_COMMAND)
    publish_until_received(controller, 0, lambda: queue.receive(0.05))
    while queue.receive(0.1) is not None:
        pass
    for tick in range(1, 6):
        controller.publish(topics.JOINT_COMMAND, command(tick))
    received = [queue.receive(2.0) for _ in range(5)]
    assert [r.message.tick for r in received if r is not None] == [1, 2, 3, 4, 5]
    sequences = [r.envelope.sequence for r in received if r is not None]
    assert np.diff(sequences).tolist() == [1, 1, 1, 1]
    assert {r.envelope.boot_id for r in received if r is not None} == {controller.boot_id}


def test_latest_gives_the_newest_and_forgets_the_rest(connect_bus: Connect) -> None:
    controller, robot = connect_bus("controller"), connect_bus("robot")
    latest = robot.latest(topics.JOINT_COMMAND)
    publish_until_received(controller, 0, lambda: latest.wait(0.05))
    for tick in range(1, 10):
        controller.publish(topics.JOINT_COMMAND, command(tick))

    def newest() -> bool:
        last = latest.last()
        return last is not None and last.message.tick == 9

    wait_until(newest)
    assert latest.take() is None
    assert latest.age_s() < 60


def test_a_call_returns_the_reply_and_leaves_a_trace(connect_bus: Connect) -> None:
    """The recorder sees calls through their traces."""
    recorder, operator = connect_bus("recorder"), connect_bus("operator")
    traces = recorder.queue(topics.TRACE)

    def mark(request: MarkRequest, context: CallContext) -> RecorderStatus:
        assert context.caller == "operator"
        return RecorderStatus(
            stamp_ns=1, recording=True, path=request.text, messages=1, bytes=2, lost={}
        )

    recorder.serve(topics.RECORD_MARK, mark)
    reply = operator.call(topics.RECORD_MARK, MarkRequest(text="here"))
    assert reply.message.path == "here"
    trace = traces.receive(5.0)
    assert trace is not None
    assert (trace.message.service, trace.message.method, trace.message.outcome) == (
        "recorder",
        "mark",
        "ok",
    )
    assert trace.message.request and trace.message.reply


def test_a_refusal_comes_back_with_its_reason(connect_bus: Connect) -> None:
    robot, operator = connect_bus("robot"), connect_bus("operator")

    def refuse(request: StopRequest, context: CallContext) -> StopReply:
        raise GoalRefusedError("point 12.0 m away, limit 10 m")

    robot.serve(topics.ROBOT_STOP, refuse)
    with pytest.raises(RefusedError, match=r"12\.0 m away, limit 10 m"):
        operator.call(topics.ROBOT_STOP, StopRequest())


def test_a_handler_that_breaks_answers_with_its_error(connect_bus: Connect) -> None:
    robot, operator = connect_bus("robot"), connect_bus("operator")

    def explode(request: StopRequest, context: CallContext) -> StopReply:
        raise ZeroDivisionError("one over nothing")

    robot.serve(topics.ROBOT_STOP, explode)
    with pytest.raises(RemoteError, match="one over nothing"):
        operator.call(topics.ROBOT_STOP, StopRequest())
    assert robot.counters["failed robot/stop"] == 1


@pytest.mark.parametrize("half", ["reply", "error"])
def test_half_a_character_does_not_leave_a_caller_without_an_answer(
    connect_bus: Connect, half: str
) -> None:
    robot, operator = connect_bus("robot"), connect_bus("operator")

    def answer(request: StopRequest, context: CallContext) -> StopReply:
        if half == "reply":
            return StopReply(mode="half \ud800", stamp_ns=1)
        raise RefusedError("half \ud800")

    robot.serve(topics.ROBOT_STOP, answer)
    with pytest.raises(
        RemoteError if half == "reply" else RefusedError, match=r"whole character|half \?"
    ):
        operator.call(topics.ROBOT_STOP, StopRequest(), timeout_s=2.0)


def test_a_call_that_nobody_serves_is_unavailable(connect_bus: Connect) -> None:
    operator = connect_bus("operator")
    with pytest.raises(UnavailableError, match="is the robot process running"):
        operator.call(topics.ROBOT_STOP, StopRequest(), timeout_s=0.3)


def assert_takes_no_calls_yet(connect_bus: Connect) -> None:
    """Call a process that is there and serves nothing; the error says so."""
    robot, operator = connect_bus("robot"), connect_bus("operator")
    wait_until(lambda: ("robot", robot.instance) in operator.alive())
    with pytest.raises(UnavailableError, match="is there and does not take robot/stop yet"):
        operator.call(topics.ROBOT_STOP, StopRequest(), timeout_s=0.3)


def test_a_process_that_is_there_but_takes_no_calls_yet_is_called_that(
    connect_bus: Connect,
) -> None:
    assert_takes_no_calls_yet(connect_bus)


@pytest.mark.parametrize("connect_bus", ["zenoh"], indirect=True)
def test_a_machine_that_is_slow_to_say_that_nobody_takes_a_call_has_not_lost_a_process(
    monkeypatch: pytest.MonkeyPatch, connect_bus: Connect
) -> None:
    monkeypatch.setattr(zenoh_bus, "NOT_DELIVERED_S", 0.0)
    monkeypatch.setattr(zenoh_bus, "GOING_PATIENCE_S", 0.01)
    assert_takes_no_calls_yet(connect_bus)


@pytest.mark.parametrize("connect_bus", ["zenoh"], indirect=True)
def test_a_process_that_goes_while_it_serves_a_call_is_told_from_one_that_takes_none(
    connect_bus: Connect,
) -> None:
    robot, operator = connect_bus("robot"), connect_bus("operator")
    begun, release = threading.Event(), threading.Event()

    def hang(request: StopRequest, context: CallContext) -> StopReply:
        begun.set()
        release.wait(20.0)
        return StopReply(mode="tracking", stamp_ns=0)

    def go() -> None:
        begun.wait(20.0)
        time.sleep(2.0 * zenoh_bus.NOT_DELIVERED_S)
        robot.close()

    robot.serve(topics.ROBOT_STOP, hang)
    going = threading.Thread(target=go)
    going.start()
    try:
        with pytest.raises(UnavailableError, match="the process died while it served the call"):
            operator.call(topics.ROBOT_STOP, StopRequest(), timeout_s=20.0)
    finally:
        release.set()
        going.join()


@pytest.mark.parametrize("connect_bus", ["zenoh"], indirect=True)
def test_the_last_try_of_a_call_is_not_made_without_time_for_an_answer(
    monkeypatch: pytest.MonkeyPatch, connect_bus: Connect
) -> None:
    robot, operator = connect_bus("robot"), connect_bus("operator")
    wait_until(lambda: ("robot", robot.instance) in operator.alive())
    tries: list[float] = []

    def nobody(_bus: object, _method: object, _instance: str, _payload: bytes, left: float) -> None:
        tries.append(left)
        if len(tries) == 1:
            time.sleep(0.26)

    monkeypatch.setattr(zenoh_bus.ZenohBus, "_ask_once", nobody)
    monkeypatch.setattr(zenoh_bus, "NOT_DELIVERED_S", 10.0)
    with pytest.raises(UnavailableError, match="is there and does not take robot/stop yet"):
        operator.call(topics.ROBOT_STOP, StopRequest(), timeout_s=0.3)
    assert len(tries) == 1


def test_a_call_waits_for_a_process_that_is_still_being_built(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Longer than for one that is not seen at all: a loaded machine takes its time to start one."""
    monkeypatch.setattr(zenoh_bus, "LIVELINESS_PATIENCE_S", 0.2)
    endpoint = free_endpoint()
    config = ServiceConfig(robot="test", router=endpoint, connect_timeout=5.0)
    with ExitStack() as stack:
        stack.enter_context(open_router(RouterConfig(listen=endpoint)))
        robot, operator = (
            stack.enter_context(connect(config, name, [endpoint])) for name in ("robot", "operator")
        )

        def finish() -> None:
            robot.serve(
                topics.ROBOT_STOP, lambda request, _: StopReply(mode=request.reason, stamp_ns=0)
            )

        wait_until(lambda: ("robot", robot.instance) in operator.alive())
        building = threading.Timer(0.5, finish)
        building.start()
        try:
            reply = operator.call(topics.ROBOT_STOP, StopRequest(reason="built"), timeout_s=20.0)
        finally:
            building.join()
        assert reply.message.mode == "built"

        robot.close()
        wait_until(lambda: ("robot", robot.instance) not in operator.alive())
        with pytest.raises(UnavailableError, match="is the robot process running"):
            operator.call(topics.ROBOT_STOP, StopRequest(), timeout_s=20.0)


def test_a_replica_can_be_asked_by_its_name(connect_bus: Connect) -> None:
    robot, operator = connect_bus("robot"), connect_bus("operator")
    robot.serve(topics.ROBOT_STOP, lambda request, _: StopReply(mode="here", stamp_ns=0))
    request = StopRequest()
    named = operator.call(topics.ROBOT_STOP, request, instance=robot.instance, timeout_s=20.0)
    assert named.message.mode == "here"
    with pytest.raises(UnavailableError):
        operator.call(topics.ROBOT_STOP, request, instance="another", timeout_s=0.3)


def test_a_slow_handler_meets_the_deadline_of_its_caller(connect_bus: Connect) -> None:
    robot, operator = connect_bus("robot"), connect_bus("operator")
    release = threading.Event()

    def slow(request: Empty, context: CallContext) -> StopReply:
        release.wait(20.0)
        return StopReply(mode="tracking", stamp_ns=0)

    robot.serve(topics.ROBOT_RESUME, slow)
    try:
        with pytest.raises(DeadlineError):
            operator.call(topics.ROBOT_RESUME, Empty(), timeout_s=0.4)
    finally:
        release.set()


def test_bytes_that_are_no_message_are_counted_and_skipped(connect_bus: Connect) -> None:
    """A broken sender costs its own message, nothing else."""
    controller, robot = connect_bus("controller"), connect_bus("robot")
    queue = robot.queue(topics.JOINT_COMMAND)
    publish_until_received(controller, 0, lambda: queue.receive(0.05))
    key = topics.JOINT_COMMAND.key("test")
    controller._send(topics.JOINT_COMMAND, key, b"\xc1 no msgpack")  # type: ignore[attr-defined]
    controller.publish(topics.JOINT_COMMAND, command(7))

    def arrived() -> bool:
        received = queue.receive(0.1)
        return received is not None and received.message.tick == 7

    wait_until(arrived)
    assert robot.counters[f"malformed {key}"] == 1


def test_a_full_queue_drops_the_oldest_and_counts_it(connect_bus: Connect) -> None:
    controller, robot = connect_bus("controller"), connect_bus("robot")
    queue = robot.queue(topics.JOINT_COMMAND, size=2)
    key = topics.JOINT_COMMAND.key("test")
    publish_until_received(controller, 0, lambda: queue.receive(0.05))
    for tick in range(20):
        controller.publish(topics.JOINT_COMMAND, command(tick))
    wait_until(lambda: robot.counters.get(f"overflow {key}", 0) >= 18)


def test_a_service_may_only_write_what_the_registry_gives_it(connect_bus: Connect) -> None:
    with pytest.raises(MessageError, match="gives it to controller"):
        connect_bus("llm").publish(topics.JOINT_COMMAND, command(1))


def test_raw_queue_gives_the_bytes_of_every_matching_key(connect_bus: Connect) -> None:
    controller, recorder = connect_bus("controller"), connect_bus("recorder")
    raw = recorder.raw_queue("w2c/v1/test/cmd/**")
    publish_until_received(controller, 3, lambda: raw.receive(0.05))


def test_liveliness_shows_who_is_there_and_who_left(connect_bus: Connect) -> None:
    robot = connect_bus("robot")
    other = connect_bus("llm")
    wait_until(lambda: ("llm", "0") in robot.alive())
    other.close()
    wait_until(lambda: ("llm", "0") not in robot.alive())


def test_no_router_is_a_clear_error() -> None:
    endpoint = free_endpoint()
    config = ServiceConfig(robot="test", router=endpoint, connect_timeout=0.2)
    with pytest.raises(ConnectionFailedError, match="w2c up"):
        connect(config, "operator", [endpoint])


def test_a_busy_port_is_a_clear_error() -> None:
    endpoint = free_endpoint()
    with (
        open_router(RouterConfig(listen=endpoint)),
        pytest.raises(ConnectionFailedError, match="another router"),
    ):
        open_router(RouterConfig(listen=endpoint))


def test_sessions_are_configured_as_decided() -> None:
    """Some settings became silent no-ops between Zenoh versions: read them back."""
    from w2c.bus.zenoh_config import base_config

    config = base_config("client")
    assert zenoh.Config.get_json(config, "scouting/multicast/enabled") == "false"
    assert zenoh.Config.get_json(config, "transport/shared_memory/enabled") == "false"
    assert zenoh.Config.get_json(config, "transport/link/tx/lease") == "1000"


def test_a_stand_in_says_and_is_what_others_were(connect_bus: Connect) -> None:
    replay, operator = connect_bus("replay"), connect_bus("operator")
    assert isinstance(replay, InProcessBus | ZenohBus)
    heard = operator.raw_queue(topics.HEALTH.key("test"))
    key = topics.HEALTH.key("test", "llm")

    def attempt() -> bool:
        replay.publish_raw(key, b"as recorded", topics.Priority.DATA)
        return heard.receive(0.1) is not None

    wait_until(attempt)
    replay.publish_raw(key, b"again", topics.Priority.DATA)
    wait_until(lambda: (raw := heard.receive(0.1)) is not None and raw.payload == b"again")

    for _ in range(2):
        replay.appear("llm", "1")
    wait_until(lambda: ("llm", "1") in operator.alive())
    for _ in range(2):
        replay.disappear("llm", "1")
    wait_until(lambda: ("llm", "1") not in operator.alive())
    assert ("replay", "0") in operator.alive()


def test_a_stand_in_answers_a_call_as_others_did_or_refuses_it(connect_bus: Connect) -> None:
    replay, operator = connect_bus("replay"), connect_bus("operator")
    assert isinstance(replay, InProcessBus | ZenohBus)
    key = topics.RECORD_STATUS.key("test", "1")
    status = RecorderStatus(stamp_ns=0, recording=True, path="", messages=1, bytes=1, lost={})

    for path in ("then.mcap", "later.mcap"):
        said = msgspec.structs.replace(status, path=path)
        replay.answer_raw(key, raw_message(said, key, boot_id="of-then").payload)
        replay.appear("recorder", "1")
        reply = operator.call(topics.RECORD_STATUS, Empty())
        assert (reply.message.path, reply.envelope.boot_id) == (path, "of-then")

    replay.refuse_raw(key, "nobody asked then")
    with pytest.raises(UnavailableError, match="nobody asked then"):
        operator.call(topics.RECORD_STATUS, Empty())


def test_a_stand_in_may_not_speak_of_another_robot() -> None:
    replay = InProcessHub().connect("replay", robot="desk")

    with pytest.raises(MessageError, match="not of desk"):
        replay.publish_raw(topics.HEALTH.key("talos", "llm"), b"x", topics.Priority.DATA)
    with pytest.raises(MessageError, match="not of desk"):
        replay.answer_raw(topics.DESCRIBE.key("talos", "0"), b"x")


def test_processes_of_another_robot_are_not_seen() -> None:
    hub = InProcessHub()
    hub.connect("controller", robot="talos")

    assert hub.connect("replay", robot="desk").alive() == [("replay", "0")]
