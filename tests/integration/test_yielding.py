"""A free hand that something pushes gives way and comes back, in the simulator."""

from dataclasses import replace

import numpy as np
import pytest

from w2c.messages import Array
from w2c_controller.controller import Controller
from w2c_controller.parameters import Parameters
from w2c_controller.seiko.force_parameters import AdmittanceGains
from w2c_sim_robot.description import make_description
from w2c_sim_robot.study import study_robot

LEFT_HAND = 2
PUSH = np.array([-25.0, 0.0, 0.0])
START, END, STOP = 1250, 2250, 4250
"""Ticks: a push of 2 s, and 4 s to come back"""
STIFF = AdmittanceGains(force_deadband=10.0, force_gain=0.0, speed=0.1)


def pushed(gains: AdmittanceGains) -> Array:
    """Return how far the hand is from where it began, (STOP, 3) [m]."""
    description = make_description(lock_step=True)
    robot = study_robot(description=description)
    own = Parameters()
    force_control = replace(own.force_control, hand_admittance=gains)
    controller = Controller(description, replace(own, force_control=force_control))
    positions = []
    for tick in range(STOP):
        if tick == START:
            robot.push(PUSH, 0.002 * (END - START), "wrist_left_ft_link")
        state = robot.state(command_tick=tick - 1, mode="tracking" if tick else "holding")
        robot.step(controller.tick(state).position)
        positions.append(robot.truth().end_effector_positions[LEFT_HAND])
    assert not robot.fell
    return np.asarray(np.array(positions) - positions[START])


@pytest.mark.slow
def test_a_pushed_hand_gives_way_and_comes_back() -> None:
    """15 N beyond the deadband: 4.5 cm/s for 2 s."""
    way = pushed(Parameters().force_control.hand_admittance)
    stiff = pushed(STIFF)
    assert np.abs(stiff[END - 1]).max() < 0.03
    assert way[END - 1, 0] - stiff[END - 1, 0] == pytest.approx(-0.09, abs=0.02)
    assert np.abs(way[-1]).max() < 0.03
