"""What of a controller goes into a snapshot, and when another controller may go on from it."""

from dataclasses import fields
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from w2c.messages import ControllerSnapshot, RobotState
from w2c_controller.kinematics.model import ControlledModel, Kinematics
from w2c_controller.motion.gaze import Neck
from w2c_controller.parameters import HANDS, Parameters
from w2c_controller.safety.guards import Guards
from w2c_controller.safety.hazards import Holds
from w2c_controller.seiko.contacts import ContactLayout
from w2c_controller.seiko.flexible_program import FlexibleProgram
from w2c_controller.seiko.program import ProgramBuilder
from w2c_controller.sensing.loads import Measured
from w2c_controller.snapshots.state_tree import capture
from w2c_controller.solvers import FallbackSolver, Program

Vector = npt.NDArray[np.float64]

CONSTANT: Final = (
    *(type(getattr(Parameters(), group.name)) for group in fields(Parameters)),
    *(Parameters, ControlledModel, Neck, FallbackSolver, ContactLayout),
)
"""Types that do not change."""
COMPUTED: Final[dict[type, tuple[str, ...]]] = {
    Kinematics: (
        "static_dq", "static_dl", "base_coupling", "_masses", "_momentum", "_loads", "_bodies",
        "_frames", "point_jacobians", "under_load", "in_motion",
    ),
    Holds: ("_reports",),
}  # fmt: skip
"""What is filled anew at each tick before it is used, or was handed on."""
KEPT: Final[dict[type, tuple[str, ...]]] = {
    # A program is filled anew at each tick; which bounds were active is where its solver starts.
    Program: ("active",),
    ProgramBuilder: ("program",),
    FlexibleProgram: ("program",),
    Guards: (
        "_previous", "_beyond", "_command", "_reference", "_found", "_overloaded", "_answers",
        "_failures",
    ),
}  # fmt: skip
"""All that is not constant, of types with many constants."""
BODY: Final = "body"
"""Where the state of the `WholeBody` stands in that of the controller."""
HOLDS: Final = "_holds"
STOP: Final = "_stop"
"""Where stands why it holds."""
MOST_MOVED: Final = 0.5
"""Between the command of the snapshot and the one in force [rad]: what free arms move in a second
or two."""
LEAST_LOAD: Final = 3.0
"""A hand that leans in the snapshot must still measure this [N]."""


def capture_controller(controller: object, own: tuple[str, ...]) -> Any:
    """Return all that changes in a controller but for the attributes that each has of its own."""
    return capture(controller, CONSTANT, {**COMPUTED, type(controller): own}, KEPT)


def refusal(
    snapshot: ControllerSnapshot, state: RobotState, robot_boot_id: str, measured: Measured
) -> str:
    """Return why a controller must not go on from a snapshot; "" = it may.

    Args:
        snapshot: Of a controller that is no more.
        state: Of the robot now.
        robot_boot_id: Of the robot now.
        measured: Loads now.
    """
    if snapshot.robot_boot_id != robot_boot_id:
        return "the robot was restarted since"
    if snapshot.tick > state.tick:
        return f"it is of tick {snapshot.tick}, and the robot is at {state.tick}"
    if snapshot.command.shape != state.command.shape:
        return f"it is of a robot with {snapshot.command.shape[0]} joints"
    moved = float(np.max(np.abs(snapshot.command - state.command)))
    if not moved < MOST_MOVED:
        return f"the command in force is {moved:.2f} rad from its, limit {MOST_MOVED} rad"
    for row, k in enumerate(HANDS):
        force = float(np.linalg.norm(measured.hands[row]))
        if snapshot.in_contact[k] and not force > LEAST_LOAD:
            return f"a hand leans in it that bears {force:.0f} N now, {LEAST_LOAD:.0f} N needed"
    return ""
