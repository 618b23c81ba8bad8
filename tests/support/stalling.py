"""Where the Retargeting stalls: what a search that does not run time ahead must find."""

import numpy as np

from w2c.messages import Array
from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import Parameters
from w2c_controller.seiko.program import clamp_norm
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.switching.stall import StallDetector

LONGEST_S = 60.0


def stall_distance(
    model: ControlledModel, joints: Array, hand: int, target: Array, dt: float
) -> float:
    """Return what is left to a point when the Retargeting has drawn a hand to its stall [m].

    Args:
        model: The robot.
        joints: (nj,) to start from, on two feet [rad].
        hand: Index of the hand.
        target: (3,) [m].
        dt: Period [s].
    """
    parameters = Parameters()
    retargeting = Retargeting(model, parameters, dt)
    retargeting.reset(joints)
    stall = StallDetector(parameters.motion, dt)
    for _ in range(round(LONGEST_S / dt)):
        position = retargeting.kinematics.positions[hand]
        lead = clamp_norm(target - position, parameters.filters.lead_position)
        retargeting.state.target_positions[hand] = position + lead
        retargeting.tick()
        retargeting.kinematics.update_frames(retargeting.state.q)
        if stall.step(retargeting.kinematics.positions[hand]):
            break
    return float(np.linalg.norm(retargeting.kinematics.positions[hand] - target))


def random_target(rng: np.random.Generator) -> tuple[int, Array]:
    """Return a hand and a point (3,) around the border of what it reaches on two feet [m]."""
    hand = int(rng.integers(2, 4))
    side = 1.0 if hand == 2 else -1.0
    azimuth = side * rng.uniform(-0.3, 1.0)
    radius, height = rng.uniform(0.75, 1.25), rng.uniform(0.5, 1.4)
    across = 0.1 * side + 0.9 * radius * np.sin(azimuth)
    return hand, np.array([radius * np.cos(azimuth), across, height])
