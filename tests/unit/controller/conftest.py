"""The simulated robot's own description is the controller's model in tests."""

import numpy as np
import pytest

from w2c.messages import Array, RobotDescription
from w2c_controller.kinematics.model import ControlledModel, build_model
from w2c_controller.parameters import Parameters
from w2c_controller.preview.search import StaticSearch
from w2c_controller.seiko.retargeting import Retargeting
from w2c_sim_robot.description import make_description


@pytest.fixture(scope="session")
def description() -> RobotDescription:
    return make_description(lock_step=True)


@pytest.fixture(scope="session")
def model(description: RobotDescription) -> ControlledModel:
    return build_model(description)


@pytest.fixture(scope="session")
def joints(description: RobotDescription, model: ControlledModel) -> Array:
    """The ready posture in the model's order."""
    return np.array(description.initial_position[model.joint_indices])


@pytest.fixture
def retargeting(model: ControlledModel, joints: Array) -> Retargeting:
    """Standing, with steps of 10 ms: five times faster tests, same equations."""
    standing = Retargeting(model, Parameters(), 0.01)
    standing.reset(joints)
    return standing


@pytest.fixture(scope="session")
def search(model: ControlledModel) -> StaticSearch:
    """One for all tests: each begins from a state of its own."""
    return StaticSearch(model)
