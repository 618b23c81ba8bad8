"""Each guard finds what it is there for, with value and limit, and nothing else."""

import msgspec
import numpy as np
import pytest

from support.states import standing_state
from w2c.messages import Array, RobotDescription
from w2c_controller.parameters import GuardLimits
from w2c_controller.safety.guards import SENSE_EVERY, Guards, joint_limits
from w2c_controller.safety.hazards import Hazard
from w2c_controller.safety.restraint import Restraint
from w2c_controller.sensing.loads import Measured

DT = 0.002
LIMITS = GuardLimits()


class Bench:
    """Guards that look at one state after another."""

    def __init__(self, description: RobotDescription) -> None:
        self.joints = joint_limits(description)
        self.guards = Guards(description, self.joints, LIMITS, DT)
        self.names = [joint.name for joint in description.joints]
        self.restraint = Restraint(self.names, self.joints, DT)
        self.noise = np.random.default_rng(0)
        self.state = standing_state(description)

    def look(self, ticks: int = 1, **changes: object) -> list[Hazard]:
        """Return all that is found while these readings stay, with a little noise on torques."""
        found: list[Hazard] = []
        for _ in range(ticks):
            fields = {"torque": self.state.torque + 1e-9 * self.noise.random()} | changes
            self.state = msgspec.structs.replace(self.state, tick=self.state.tick + 1, **fields)
            found += self.guards.inspect(self.state, used=self.state.tick % SENSE_EVERY == 0)
        return found

    def ticks(self, seconds: float) -> int:
        return round(seconds / DT)

    def largest_step(self, joint: int) -> float:
        """Return what a joint may move in a tick [rad]: its range in 0.75 s."""
        return float((self.joints.upper - self.joints.lower)[joint]) * DT / 0.75

    def with_value(self, array: Array, joint: int, value: float) -> Array:
        changed = array.copy()
        changed[joint] = value
        return changed


@pytest.fixture
def bench(description: RobotDescription) -> Bench:
    return Bench(description)


def test_a_robot_that_stands_is_nothing_to_report(bench: Bench) -> None:
    assert bench.look(1000) == []


@pytest.mark.parametrize(
    ("field", "at", "subject"),
    [
        ("position", 3, "position of"),
        ("velocity", 0, "velocity of"),
        ("torque", 26, "torque of"),
        ("sole_wrenches", (1, 2), "right foot sensor"),
        ("left_wrist_wrench", 5, "left wrist sensor"),
    ],
)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_reading_that_is_no_number_is_named(
    bench: Bench, field: str, at: object, subject: str, value: float
) -> None:
    readings = getattr(bench.state, field).copy()
    readings[at] = value
    found = bench.look(SENSE_EVERY, **{field: readings})
    assert {hazard.cause for hazard in found} == {"sensor_not_finite"}
    assert found[0].subject.startswith(subject)


def test_only_what_is_used_is_looked_at(bench: Bench) -> None:
    readings = bench.with_value(bench.state.position, 0, np.nan)
    state = msgspec.structs.replace(bench.state, position=readings)
    assert bench.guards.inspect(state, used=False) == ()
    (found,) = bench.guards.inspect(state, used=True)
    assert found.cause == "sensor_not_finite"


@pytest.mark.parametrize(
    ("cause", "field", "time", "over"),
    [
        ("position_limit", "position", LIMITS.position_time, 0.01),
        ("velocity_limit", "velocity", LIMITS.velocity_time, 0.1),
        ("torque_limit", "torque", LIMITS.torque_time, 1.0),
    ],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_limit_is_exceeded_only_after_a_while(
    bench: Bench, cause: str, field: str, time: float, over: float, sign: float
) -> None:
    joints, joint = bench.joints, 5
    limit = {
        "position": (joints.upper if sign > 0 else joints.lower)[joint]
        + sign * LIMITS.position_margin,
        "velocity": sign * joints.velocity[joint],
        "torque": sign * LIMITS.torque_factor * joints.effort[joint],
    }[field]
    rest = getattr(bench.state, field)
    within = bench.with_value(rest, joint, limit - sign * over)
    beyond = bench.with_value(rest, joint, limit + sign * over)
    command = within if field == "position" else bench.state.command
    assert bench.look(200, **{field: within, "command": command}) == []
    assert bench.look(SENSE_EVERY, **{field: beyond}) == [] or time <= SENSE_EVERY * DT * 1.5
    bench.look(200, **{field: within})
    found = bench.look(bench.ticks(time) + 2 * SENSE_EVERY, **{field: beyond})
    assert {hazard.cause for hazard in found} == {cause}
    assert found[0].subject == bench.names[joint]
    assert found[0].limit == pytest.approx(limit)
    assert found[0].value == pytest.approx(limit + sign * over)


def test_spikes_that_come_again_and_again_are_no_fault(bench: Bench) -> None:
    rest = bench.state.velocity
    spike = bench.with_value(rest, 5, bench.joints.velocity[5] + 0.1)
    for _ in range(10):
        assert bench.look(SENSE_EVERY, velocity=spike) == []
        assert bench.look(SENSE_EVERY, velocity=rest) == []


@pytest.mark.parametrize("way", [0.21, -0.21])
def test_a_joint_that_does_not_follow_its_command_is_named(bench: Bench, way: float) -> None:
    command = bench.with_value(bench.state.command, 4, bench.state.command[4] + way)
    assert bench.look(bench.ticks(LIMITS.following_time) // 2, command=command) == []
    found = bench.look(bench.ticks(LIMITS.following_time), command=command)
    assert {hazard.cause for hazard in found} == {"not_following"}
    assert found[0].subject == bench.names[4]


@pytest.mark.parametrize("way", [0.002, -0.002])
def test_readings_that_stay_the_same_bit_by_bit_while_the_command_moves_are_frozen(
    bench: Bench, way: float
) -> None:
    torque = bench.state.torque.copy()
    assert bench.look(500, torque=torque) == [], "standing still is no fault"
    moved = bench.with_value(bench.state.command, 0, bench.state.command[0] + way)
    found = bench.look(bench.ticks(LIMITS.frozen_time), torque=torque, command=moved)
    assert {hazard.cause for hazard in found} == {"sensor_frozen"}
    assert bench.look(100, command=moved) == [], "one reading that changes is enough"


def test_frozen_readings_are_found_a_tenth_of_a_second_after_their_last_change(
    bench: Bench,
) -> None:
    torque = bench.state.torque.copy()
    bench.look(SENSE_EVERY, torque=torque)
    moved = bench.with_value(bench.state.command, 0, bench.state.command[0] + 0.002)
    found = bench.look(
        bench.ticks(LIMITS.frozen_time) + 2 * SENSE_EVERY, torque=torque, command=moved
    )
    assert {hazard.cause for hazard in found} == {"sensor_frozen"}


def test_a_short_standstill_of_the_readings_is_no_fault(bench: Bench) -> None:
    torque = bench.state.torque.copy()
    bench.look(SENSE_EVERY, torque=torque)
    moved = bench.with_value(bench.state.command, 0, bench.state.command[0] + 0.002)
    assert bench.look(bench.ticks(LIMITS.frozen_time) // 2, torque=torque, command=moved) == []


def test_standstills_with_a_change_between_them_are_no_fault(bench: Bench) -> None:
    command, half = bench.state.command, bench.ticks(LIMITS.frozen_time) // 2
    for times in range(1, 5):
        moved = bench.with_value(command, 0, command[0] + 0.002 * times)
        torque = bench.state.torque + 1e-6
        assert bench.look(SENSE_EVERY, torque=torque) == []
        assert bench.look(half, torque=torque, command=moved) == []


def test_a_driver_that_takes_no_command_is_noticed(bench: Bench) -> None:
    assert bench.look(bench.ticks(LIMITS.refused_time) // 2, mode="holding") == []
    found = bench.look(bench.ticks(LIMITS.refused_time), mode="holding")
    assert {hazard.cause for hazard in found} == {"command_not_taken"}
    assert bench.look(10, mode="tracking") == []


def test_a_command_may_not_jump(bench: Bench) -> None:
    restraint, before = bench.restraint, bench.state.command
    jump = 5.0 * bench.largest_step(2)
    faulty = bench.with_value(before, 2, before[2] - 1.01 * jump)
    hazard = restraint.apply(faulty, before)
    assert hazard is not None
    assert hazard.cause == "command_jump"
    assert hazard.subject == bench.names[2]
    assert hazard.limit == pytest.approx(jump)
    assert restraint.apply(bench.with_value(before, 2, before[2] - 0.99 * jump), before) is None


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_command_that_is_too_fast_arrives_later(bench: Bench, sign: float) -> None:
    largest, before = bench.largest_step(2), bench.state.command
    wanted = bench.with_value(before, 2, before[2] + sign * 2.5 * largest)
    sent = before
    for share in (1.0, 2.0, 2.5, 2.5):
        command = wanted.copy()
        assert bench.restraint.apply(command, sent) is None
        np.testing.assert_array_equal(np.delete(command, 2), np.delete(before, 2))
        assert command[2] - before[2] == pytest.approx(sign * share * largest)
        sent = command


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_command_must_be_finite(bench: Bench, value: float) -> None:
    before = bench.state.command
    hazard = bench.restraint.apply(bench.with_value(before, 7, value), before)
    assert hazard is not None
    assert hazard.cause == "command_not_finite"


@pytest.mark.parametrize("hand", [0, 1])
@pytest.mark.parametrize("force", [(180.0, 180.0, 0.0), (0.0, -180.0, 180.0), (180.0, 0.0, -180.0)])
def test_a_hand_may_bear_much_for_a_moment_only(
    bench: Bench, hand: int, force: tuple[float, float, float]
) -> None:
    light = Measured(feet=np.zeros((2, 6)), hands=np.zeros((2, 3)))
    heavy = Measured(feet=np.zeros((2, 6)), hands=np.zeros((2, 3)))
    heavy.hands[hand] = force
    guards, step = bench.guards, LIMITS.hand_time / 2
    assert guards.inspect_loads(heavy, step) is None
    assert guards.inspect_loads(light, step) is None
    assert guards.inspect_loads(heavy, step) is None
    hazard = guards.inspect_loads(heavy, step)
    assert hazard is not None
    assert hazard.cause == "hand_overload"
    assert hazard.subject == ("left_hand", "right_hand")[hand]
    assert hazard.value == pytest.approx(np.linalg.norm(force))


def test_a_load_that_is_not_known_is_no_overload(bench: Bench) -> None:
    unknown = Measured(feet=np.zeros((2, 6)), hands=np.full((2, 3), np.nan))
    assert bench.guards.inspect_loads(unknown, 2.0 * LIMITS.hand_time) is None


def test_many_programs_in_a_row_without_solution_are_a_fault(bench: Bench) -> None:
    for _ in range(LIMITS.failed_programs - 1):
        assert bench.guards.inspect_solution(solved=False) is None
    assert bench.guards.inspect_solution(solved=True) is None
    for _ in range(LIMITS.failed_programs - 1):
        assert bench.guards.inspect_solution(solved=False) is None
    hazard = bench.guards.inspect_solution(solved=False)
    assert hazard is not None
    assert hazard.cause == "qp_failed"
