"""Each constraint of the Retargeting QP: where it binds, and where it cannot hold.

A demand on the equalities (an external force, or a contact that moves) is raised until no solution
is left. Just below, the constraint that is tested must be active; with a looser limit the same
demand must be feasible.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from w2c.errors import SolverError
from w2c.messages import Array
from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import Clamps, Limits, Parameters
from w2c_controller.seiko.contacts import ContactLayout
from w2c_controller.seiko.program import ProgramBuilder
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.solvers import FallbackSolver, Program

DT = 0.01
RIGHT_HAND = 3
NV = 31
NO_CLAMPS = Clamps(bias_force=1e9, bias_torque=1e9, bias_position=1.0, bias_rotation=1.0)
FREE = Limits(
    joint_margin=-10.0,
    velocity_fraction=1e4,
    balance_velocity_fraction=1e4,
    torque_fraction=1e3,
    friction=1e2,
    cop_x=10.0,
    cop_y=10.0,
    foot_force_min=0.0,
    foot_force_max=1e5,
    hand_force_min=0.0,
    hand_force_max=1e5,
    foot_force_rate=1e7,
    foot_torque_rate=1e7,
    hand_force_rate=1e7,
)
"""Nothing binds."""
STILL = replace(FREE, velocity_fraction=0.05, balance_velocity_fraction=0.05)
"""Nothing binds, but the robot cannot get out of a demand by another posture."""
PLANE_ROWS = {"friction": (0, 1, 4, 5), "pressure": (2, 3, 6, 7), "torsion": tuple(range(8, 16))}


@dataclass(frozen=True)
class Case:
    """A constraint, and what drives a robot against it."""

    name: str
    limits: Limits
    demand: Array
    """(6,) external force and torque on the base, at most [N, Nm]"""
    rows: Callable[[ProgramBuilder], list[int]]
    """Which bounds of the program are those of the constraint"""
    hand: bool = False
    moved: float = 0.0
    """How far the left foot's place moves sideways, at most [m]"""


def joints(_: ProgramBuilder) -> list[int]:
    return list(range(6, NV))


def normals(builder: ProgramBuilder) -> list[int]:
    return [where.start + 2 for where in builder.layout.slices.values()]


def rates(builder: ProgramBuilder) -> list[int]:
    return list(range(NV, builder.layout.size))


def torques(builder: ProgramBuilder) -> list[int]:
    first = builder.layout.size + builder.layout.equality_rows
    return list(range(first, first + 25))


def cone(kind: str) -> Callable[[ProgramBuilder], list[int]]:
    def rows(builder: ProgramBuilder) -> list[int]:
        first = torques(builder)[-1] + 1
        return [first + 16 * foot + row for foot in (0, 1) for row in PLANE_ROWS[kind]]

    return rows


def hand_cone(builder: ProgramBuilder) -> list[int]:
    first = torques(builder)[-1] + 1 + 32
    return list(range(first, first + 4))


def hand_normal(builder: ProgramBuilder) -> list[int]:
    return [builder.layout.slices[RIGHT_HAND].start + 2]


def hand_rates(builder: ProgramBuilder) -> list[int]:
    where = builder.layout.slices[RIGHT_HAND]
    return list(range(where.start, where.stop))


def push(*values: float) -> Array:
    return np.array([*values, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0][:6])


WEAK_FEET = replace(STILL, foot_force_rate=1.0, foot_torque_rate=1.0)
SOLE = replace(STILL, friction=0.6, cop_x=0.04, cop_y=0.03)
SLOW = replace(FREE, velocity_fraction=0.01, balance_velocity_fraction=0.01)
CASES = [
    Case("velocity", SLOW, push(), joints, moved=0.05),
    Case("joint limits", replace(FREE, joint_margin=0.3), push(), joints, moved=1.5),
    Case("torque", replace(STILL, torque_fraction=0.5), push(0, 0, 5e3), torques),
    Case("wrench rate", replace(STILL, foot_force_rate=60.0), push(0, 0, 50.0), rates),
    Case("least normal force", replace(STILL, foot_force_min=100.0), push(0, 0, -800.0), normals),
    Case("largest normal force", replace(STILL, foot_force_max=1e3), push(0, 0, 3e3), normals),
    Case("friction", replace(STILL, friction=0.6), push(2e3), cone("friction")),
    Case("pressure", replace(STILL, cop_x=0.04), push(0, 0, 0, 0, 500.0), cone("pressure")),
    Case("torsion", SOLE, push(0, 0, 0, 0, 0, 500.0), cone("torsion")),
    Case("hand's friction", replace(STILL, friction=0.3), push(0, 2e3), hand_cone, hand=True),
    Case(
        "hand's largest force",
        replace(STILL, foot_force_max=500.0, hand_force_max=50.0),
        push(0, 0, 2e3),
        hand_normal,
        hand=True,
    ),
    Case(
        "hand's rate",
        replace(WEAK_FEET, hand_force_rate=10.0),
        push(0, 0, 20.0),
        hand_rates,
        hand=True,
    ),
]


@pytest.fixture(scope="module")
def robots(model: ControlledModel, joints: Array) -> dict[bool, Retargeting]:
    """Robots on two feet, and with the right hand on a table, without and with a hand."""
    result = {}
    for hand in (False, True):
        robot = Retargeting(model, Parameters(), DT)
        robot.reset(joints)
        if hand:
            robot.enable(RIGHT_HAND, np.eye(3))
            for _ in range(300):
                robot.tick()
        result[hand] = robot
    return result


def solve(
    robot: Retargeting, case: Case, limits: Limits, scale: float
) -> tuple[ProgramBuilder, Program, Array] | None:
    """Return the program of a share of a demand, and the values of x and its rows at the optimum.

    None where it has no solution.
    """
    parameters = replace(Parameters(), limits=limits, clamps=NO_CLAMPS)
    layout = ContactLayout(robot.state.enabled, NV)
    builder = ProgramBuilder(layout, robot.controlled, parameters, DT)
    state, kinematics = robot.state.copy(), robot.kinematics
    state.force_min[:2] = limits.foot_force_min
    state.target_positions[0, 1] += scale * case.moved
    program = builder.fill(kinematics, state)
    equilibrium = slice(program.size + program.equalities - 6, program.size + program.equalities)
    for right in (program.lower, program.upper):
        right[equilibrium] -= scale * case.demand / DT
    try:
        x = FallbackSolver().solve(program)
    except SolverError:
        return None
    assert program.violation(x) < 1e-4
    return builder, program, np.concatenate([x, program.rows @ x])


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_constraint_binds_and_then_cannot_hold(
    robots: dict[bool, Retargeting], case: Case
) -> None:
    robot = robots[case.hand]
    assert solve(robot, case, case.limits, 0.0) is not None
    assert solve(robot, case, case.limits, 1.0) is None, "the demand can be met"
    loose = FREE if case.moved else STILL
    assert solve(robot, case, loose, 1.0) is not None, "it is not this limit that forbids it"
    low, high = 0.0, 1.0
    for _ in range(24):
        middle = 0.5 * (low + high)
        if solve(robot, case, case.limits, middle) is None:
            high = middle
        else:
            low = middle
    solved = solve(robot, case, case.limits, low)
    assert solved is not None
    builder, program, values = solved
    rows = case.rows(builder)
    gaps = np.minimum(program.upper - values, values - program.lower)[rows]
    sizes = np.minimum(np.abs(program.upper), np.abs(program.lower))[rows]
    assert np.min(gaps / np.maximum(sizes, 1.0)) < 1e-3
