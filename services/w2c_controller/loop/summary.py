"""What the controller does, for the status message."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from w2c.messages.control import Phase
from w2c_controller.parameters import HANDS
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.sensing.loads import Measured
from w2c_controller.switching.switching import Switching

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Snapshot:
    """Of one tick; arrays over end effectors, in the world."""

    tick: int
    phase: Phase
    goal_id: str
    end_effector: str
    task: str
    distance: float
    in_contact: tuple[bool, bool, bool, bool]
    desired_forces: Matrix
    """(4, 3) [N]"""
    positions: Matrix
    """(4, 3) [m]"""
    loads: Vector
    """(4,) [N]"""
    solver_failures: int
    message: str
    sole_rotations: Matrix | None
    """(2, 3, 3) of the feet; None while the posture is not known"""


def summarize(
    tick: int,
    phase: Phase,
    message: str,
    retargeting: Retargeting,
    switching: Switching | None,
    measured: Measured,
) -> Snapshot:
    """Return what is under way at a tick; without a switching nothing is."""
    state, rotations = retargeting.state, retargeting.kinematics.rotations
    loads = np.zeros(4)
    loads[:2] = measured.feet[:, 2]
    goal = None
    if switching is not None:
        goal = switching.goal
        for k in HANDS:
            loads[k] = switching.normal_load(k, measured)
    return Snapshot(
        tick=tick,
        phase=phase,
        goal_id=goal.goal_id if goal else "",
        end_effector=goal.end_effector if goal else "",
        task=goal.task if goal else "",
        distance=switching.distance() if switching and goal else -1.0,
        in_contact=state.enabled,
        desired_forces=np.stack([state.world_force(k, rotations) for k in range(4)]),
        positions=retargeting.kinematics.positions.copy(),
        loads=loads,
        solver_failures=retargeting.failures,
        message=message,
        sole_rotations=rotations[:2].copy() if switching is not None else None,
    )
