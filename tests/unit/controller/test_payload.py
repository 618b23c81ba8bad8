"""What hangs on the hands becomes part of the model, and is no contact force."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from w2c.messages import RobotDescription
from w2c_controller.controller import Controller
from w2c_controller.kinematics.model import (
    ControlledModel,
    Kinematics,
    build_model,
    standing_configuration,
)
from w2c_controller.parameters import RIGHT_HAND
from w2c_controller.safety.takeover import find_supports
from w2c_controller.seiko.force_parameters import ForceParameters
from w2c_controller.sensing.loads import Measured
from w2c_controller.sensing.payload import GRAVITY, Payloads
from w2c_sim_robot.perturbation import Perturbation
from w2c_sim_robot.study import study_robot

BOTH = (True, True)
DT = 0.008


@pytest.fixture
def controlled(description: RobotDescription) -> ControlledModel:
    return build_model(description)


def weighing(left: float, right: float) -> Measured:
    """Return what is measured with these masses in the hands [kg]."""
    hands = np.array([[0.0, 0.0, -GRAVITY * left], [0.0, 0.0, -GRAVITY * right]])
    return Measured(feet=np.zeros((2, 6)), hands=hands)


def test_the_model_feels_the_mass_as_a_point_at_the_hand(
    controlled: ControlledModel, description: RobotDescription
) -> None:
    joints = description.initial_position[controlled.joint_indices]
    q = standing_configuration(controlled, joints)
    loaded = pin.Model(controlled.model)
    frame = loaded.frames[controlled.frames[RIGHT_HAND]]
    point = pin.Inertia(7.0, np.zeros(3), np.zeros((3, 3)))
    loaded.appendBodyToJoint(frame.parentJoint, point, frame.placement)
    expected = pin.computeGeneralizedGravity(loaded, loaded.createData(), q)

    Payloads(controlled, ForceParameters(), DT).begin(weighing(0.0, 7.0), BOTH)
    kinematics = Kinematics(controlled)
    kinematics.update_frames(q)
    nothing = (False, False, False, False)
    kinematics.update_statics(q, np.zeros((4, 6)), np.zeros((4, 3, 3)), nothing)
    assert kinematics.static == pytest.approx(expected, abs=1e-9)


def test_put_down_the_model_is_what_it_was(controlled: ControlledModel) -> None:
    weights, centers = controlled.tree.weights.copy(), controlled.tree.centers.copy()
    payloads = Payloads(controlled, ForceParameters(), DT)
    payloads.begin(weighing(3.0, 7.0), BOTH)
    assert not np.allclose(controlled.tree.weights, weights)
    payloads.begin(weighing(0.0, 0.0), BOTH)
    assert controlled.tree.weights == pytest.approx(weights, abs=1e-12)
    assert controlled.tree.centers == pytest.approx(centers, abs=1e-12)


def test_learns_slowly_and_only_from_hands_that_are_free(controlled: ControlledModel) -> None:
    parameters = ForceParameters()
    payloads = Payloads(controlled, parameters, DT)
    for _ in range(round(1.0 / DT)):
        payloads.learn(weighing(5.0, 5.0), (True, False))
    assert payloads.masses == pytest.approx([parameters.payload_rate, 0.0], abs=1e-9)


def test_stops_at_the_mass_that_is_there(controlled: ControlledModel) -> None:
    payloads = Payloads(controlled, replace(ForceParameters(), payload_rate=10.0), DT)
    for _ in range(round(2.0 / DT)):
        payloads.learn(weighing(5.0, 0.0), BOTH)
    assert payloads.masses == pytest.approx([5.0, 0.0], abs=1e-12)


def test_what_contacts_exert_is_what_is_left(controlled: ControlledModel) -> None:
    payloads = Payloads(controlled, ForceParameters(), DT)
    payloads.begin(weighing(0.0, 4.0), BOTH)
    measured = weighing(0.0, 4.0)
    measured.hands[1] += (3.0, -2.0, 20.0)
    assert payloads.relieve(measured).hands[1] == pytest.approx([3.0, -2.0, 20.0])


@pytest.mark.parametrize("measured", [weighing(0.0, 0.2), weighing(-4.0, -4.0)])
def test_a_light_touch_and_a_push_from_below_are_no_mass(
    controlled: ControlledModel, measured: Measured
) -> None:
    payloads = Payloads(controlled, ForceParameters(), DT)
    payloads.begin(measured, BOTH)
    assert not payloads.masses.any()
    assert payloads.relieve(measured) is measured


def test_a_broken_sensor_changes_nothing(controlled: ControlledModel) -> None:
    payloads = Payloads(controlled, ForceParameters(), DT)
    payloads.begin(weighing(0.0, 4.0), BOTH)
    payloads.learn(weighing(0.0, float("nan")), BOTH)
    assert payloads.masses == pytest.approx([0.0, 4.0])


def test_without_force_control_nothing_is_learnt(controlled: ControlledModel) -> None:
    payloads = Payloads(controlled, replace(ForceParameters(), mode="off"), DT)
    payloads.begin(weighing(0.0, 4.0), BOTH)
    assert not payloads.masses.any()


def test_a_load_in_the_hand_is_no_support() -> None:
    assert find_supports(weighing(0.0, 12.0)) == {}
    assert set(find_supports(weighing(0.0, -12.0))) == {RIGHT_HAND}


def test_the_controller_knows_the_load_from_its_first_tick(description: RobotDescription) -> None:
    mass = 6.0
    robot = study_robot(Perturbation(hand_mass=(0.0, mass)), description=description)
    controller = Controller(description)
    controller.tick(robot.state())
    feet = controller.retargeting.state.wrenches[:2, 2].sum()
    weight = robot.model.body_mass.sum() * GRAVITY
    assert feet == pytest.approx(weight, abs=0.1)
    assert controller.requests.situation.away == (False, False)
