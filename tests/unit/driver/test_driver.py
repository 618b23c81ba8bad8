"""Any machine behind the driver: what it is told, what is published, and what goes wrong."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from support.machines import PERIOD_NS, URDF, ObedientMachine, ScriptedClock, describe
from w2c import topics
from w2c.bus.inprocess import InProcessBus, InProcessHub
from w2c.clock import Clock, StepClock
from w2c.driver import Driver, DriverConfig, Machine
from w2c.driver.limits import joint_limits
from w2c.driver.meter import Meter
from w2c.errors import ConfigError, RecordingError
from w2c.messages import Array, Empty, JointCommand, StopRequest
from w2c.messages.robot import DriverMode

CONFIG = DriverConfig(robot="test", real_time="off")


@contextmanager
def driver_of(
    machine: Machine, hub: InProcessHub, clock: Clock, processor_ns: Callable[[], int] = lambda: 0
) -> Iterator[Driver]:
    bus = hub.connect("robot")
    driver = Driver(CONFIG, bus, clock, lambda: machine, processor_ns=processor_ns)
    try:
        driver.configure()
        yield driver
    finally:
        driver.close()
        bus.close()


def run_for(ticks: int, machine: ObedientMachine, act: Callable[[int], None] = lambda _: None,
            hub: InProcessHub | None = None) -> Driver:  # fmt: skip
    """Run the driver in real time, as fast as it goes; `act` is called at each deadline."""
    stop = threading.Event()

    def at_tick(tick: int) -> None:
        act(tick)
        if tick == ticks - 1:
            stop.set()

    with driver_of(machine, hub or InProcessHub(), ScriptedClock(at_tick)) as driver:
        driver.run(stop)
    return driver


def command(bus: InProcessBus, tick: int, angles: Array) -> None:
    bus.publish(topics.JOINT_COMMAND, JointCommand(tick=tick, position=angles))


def test_a_machine_is_told_good_commands_and_holds_the_last_one() -> None:
    hub, machine = InProcessHub(), ObedientMachine(describe())
    controller = hub.connect("controller")
    good = machine.command + 1e-4

    def act(tick: int) -> None:
        if tick == 3:
            command(controller, 3, good)
        if tick == 5:
            command(controller, 5, good + 0.5)  # jumps

    run_for(40, machine, act, hub)
    angles = [told[0][0] for told in machine.told]
    assert angles[:3] == [0.0] * 3
    assert set(angles[3:]) == {1e-4}
    modes = [told[1] for told in machine.told]
    assert modes[:3] == ["holding"] * 3
    assert modes[3:28] == ["tracking"] * 25
    assert set(modes[29:]) == {"holding"}
    assert machine.closed


def test_stop_reaches_the_machine_and_no_command_does_until_resumed() -> None:
    hub, machine = InProcessHub(), ObedientMachine(describe())
    controller, operator = hub.connect("controller"), hub.connect("operator")

    def act(tick: int) -> None:
        if tick == 5:
            assert operator.call(topics.ROBOT_STOP, StopRequest(reason="x")).message.stamp_ns == (
                5 * PERIOD_NS
            )
        if tick == 10:
            operator.call(topics.ROBOT_RESUME, Empty())
        command(controller, tick, machine.command + 1e-5)

    run_for(15, machine, act, hub)
    assert [told[1] for told in machine.told] == 5 * ["tracking"] + 5 * ["stopped"] + 5 * [
        "tracking"
    ]
    assert machine.told[9][0].tolist() == machine.told[4][0].tolist()


def test_a_machine_may_say_more_than_its_state() -> None:
    hub = InProcessHub()
    lines = hub.connect("console").queue(topics.LOG)
    run_for(25, ObedientMachine(describe()), hub=hub)
    texts = []
    while (line := lines.receive(0.0)) is not None:
        texts.append(line.message.text)
    assert texts == ["tick 0", "tick 10", "tick 20"]


def test_statistics_tell_pace_work_and_late_periods() -> None:
    """Each step takes 0.5 ms by the clock; two periods in a row come late, one far too late."""

    class SlowMachine(ObedientMachine):
        def step(self, command: Array, mode: DriverMode) -> None:
            clock.now += 500_000
            super().step(command, mode)

    hub, machine = InProcessHub(), SlowMachine(describe())
    queue = hub.connect("console").queue(topics.ROBOT_STATISTICS)
    clock: ScriptedClock

    stop = threading.Event()

    def at_tick(tick: int) -> None:
        if tick == 100:
            clock.now += 5_000_000  # this period and the next are more than 2 ms late
        if tick == 200:
            clock.now += 30_000_000
        if tick == 500:
            stop.set()

    clock = ScriptedClock(at_tick)
    with driver_of(machine, hub, clock, lambda: clock.now) as driver:
        driver.run(stop)
        detail = driver.detail
    found = []
    while (received := queue.receive(0.0)) is not None:
        found.append(received.message)
    assert [entry.tick for entry in found] == [250, 500]
    first, second = found
    assert first.stamp_ns == 250 * PERIOD_NS
    assert first.real_time_factor == pytest.approx(4.0)
    assert first.pace == pytest.approx(500.0 / 530.0, abs=0.01)
    assert second.pace == pytest.approx(1.0, abs=0.01)
    assert (second.late_periods, second.gaps_20ms) == (3, 1)
    assert second.lateness_max_us == pytest.approx(30_000.0)
    assert detail == "4.0x real time, runs at 1.00x, 3 late periods"


def test_a_machine_that_breaks_ends_the_driver_and_is_let_go_of() -> None:
    machine = ObedientMachine(describe())
    machine.breaks_at = 4
    with pytest.raises(OSError, match="the line is dead"):
        run_for(10, machine)
    assert machine.closed


def test_before_it_is_configured_a_driver_has_no_machine() -> None:
    bus = InProcessHub().connect("robot")

    def fail() -> Machine:
        raise RecordingError("no recording at x")

    driver = Driver(CONFIG, bus, StepClock(), fail)
    with pytest.raises(ConfigError, match="no machine yet"):
        _ = driver.machine
    with pytest.raises(RecordingError):
        driver.configure()
    driver.close()


def test_a_machine_whose_command_does_not_fit_its_description_is_refused() -> None:
    machine = ObedientMachine(describe())
    machine.command = np.zeros(3)
    with (
        pytest.raises(ConfigError, match=r"shape \(3,\), its description 2 joints"),
        driver_of(machine, InProcessHub(), StepClock()),
    ):
        pass


def test_limits_are_those_of_the_urdf_in_the_order_of_the_description() -> None:
    assert joint_limits(describe()).tolist() == [[-1.0, 1.0], [0.0, 0.5]]


@pytest.mark.parametrize(
    ("urdf", "words"),
    [
        ("<robot", "holds no URDF"),
        (URDF.replace('lower="-1"', 'lower="low"'), "limits of joint 'hip'"),
        (URDF.replace('name="rail"', 'name="other"'), "no lower and upper limit for: rail"),
        (URDF.replace('upper="1"', 'upper="-1"'), "no lower and upper limit for: hip"),
    ],
)
def test_a_description_without_limits_is_refused(urdf: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        joint_limits(describe(urdf=urdf))


def test_a_meter_tells_pace_and_factor_since_it_was_read() -> None:
    clock, processor = StepClock(), StepClock(500)
    meter = Meter(clock, PERIOD_NS, processor.now_ns)
    assert meter.read() == (0.0, 0.0)
    for _ in range(10):
        meter.begin()
        processor.set(processor.now_ns() + 1_000_000)
        meter.end()
        processor.set(processor.now_ns() + 500_000)  # not the machine's
        clock.set(clock.now_ns() + 4_000_000)
    assert meter.read() == (0.5, 2.0)
    meter.begin()
    meter.end()
    assert meter.read() == (0.0, 0.0)
