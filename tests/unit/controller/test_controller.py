"""One state in, one command out: start, stop, resume, and the elastic offset."""

import msgspec
import numpy as np
import pinocchio as pin
import pytest

from fakes.ideal_robot import IdealRobot
from w2c.errors import ControlError, GoalRefusedError
from w2c.messages import PlaceGoal, ReleaseGoal, RobotDescription
from w2c_controller.controller import Controller
from w2c_controller.kinematics.model import Kinematics
from w2c_controller.parameters import Parameters
from w2c_controller.seiko.force_parameters import ForceParameters

UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture
def description(description: RobotDescription) -> RobotDescription:
    """A robot with ticks of 10 ms: five times faster tests."""
    return msgspec.structs.replace(description, period_ns=10_000_000)


@pytest.fixture
def robot(description: RobotDescription) -> IdealRobot:
    return IdealRobot(description)


@pytest.fixture
def controller(description: RobotDescription) -> Controller:
    return Controller(description)


@pytest.fixture
def without_feedback(description: RobotDescription) -> Controller:
    """A controller that believes its model: the robot here feels nothing of what it commands."""
    feedback = ForceParameters(proportional=0.0)
    return Controller(description, Parameters(force_control=feedback))


def reach(goal_id: str, x: float = 0.7, effective_tick: int = -1) -> PlaceGoal:
    return PlaceGoal(
        goal_id=goal_id,
        end_effector="left_hand",
        task="reach",
        point=np.array([x, 0.3, 0.95]),
        normal=UP,
        effective_tick=effective_tick,
    )


def test_the_first_command_is_the_one_in_force(controller: Controller, robot: IdealRobot) -> None:
    robot.command = robot.command + 0.01
    before = robot.command.copy()
    answer = robot.step(controller)
    assert answer.tick == 0
    np.testing.assert_allclose(answer.position, before, atol=1e-4)


def test_no_command_jumps(controller: Controller, robot: IdealRobot) -> None:
    previous = robot.command
    for _ in range(240):
        answer = robot.step(controller).position
        assert np.abs(answer - previous).max() < 1e-3
        previous = answer


def test_standing_is_commanded_with_the_elastic_offset(
    without_feedback: Controller, robot: IdealRobot
) -> None:
    controller = without_feedback
    answer = robot.step(controller, 220).position[controller.model.joint_indices]
    state = controller.retargeting.state
    np.testing.assert_allclose(
        (answer - state.q[7:]) * controller.model.stiffness, state.torque, atol=1.5
    )
    knee = controller.model.joint_names.index("leg_left_4_joint")
    assert abs(state.torque[knee]) > 20.0


def test_without_force_control_the_desired_posture_is_commanded(
    description: RobotDescription, robot: IdealRobot
) -> None:
    controller = Controller(description, Parameters(force_control=ForceParameters(mode="off")))
    answer = robot.step(controller, 220).position[controller.model.joint_indices]
    np.testing.assert_array_equal(answer, controller.retargeting.state.q[7:])


def test_the_offset_contains_the_force_of_the_hand(
    without_feedback: Controller, robot: IdealRobot
) -> None:
    controller = without_feedback
    robot.step(controller, 220)
    controller.retargeting.enable(3, np.eye(3))
    robot.step(controller, 300)
    state, model = controller.retargeting.state, controller.model
    assert state.wrenches[3, 2] > 20.0
    kinematics = Kinematics(model)
    kinematics.update_frames(state.q)
    gravity = pin.computeGeneralizedGravity(model.model, model.model.createData(), state.q)
    arm, radius = model.joints_of(3), np.array([0.0, 0.0, model.hand_radius[1]])
    # At the lowest point of the ball.
    jacobian = kinematics.jacobians[3, :3, arm] + np.cross(radius, kinematics.jacobians[3, 3:, arm])
    with_force = gravity[arm] - jacobian @ state.wrenches[3, :3]
    np.testing.assert_allclose(state.torque[arm - 6], with_force, atol=0.05)
    flexible = controller.force_control.flexible
    wound = controller.model.stiffness * (state.q[7:] + flexible.offset - flexible.q[7:])
    np.testing.assert_allclose(wound[arm - 6], with_force, atol=0.5)


def test_the_head_keeps_its_gaze_while_the_robot_stands(
    controller: Controller, robot: IdealRobot, description: RobotDescription
) -> None:
    answer = robot.step(controller, 220)
    for name in ("head_1_joint", "head_2_joint"):
        index = [joint.name for joint in description.joints].index(name)
        start = description.initial_position[index]
        assert answer.position[index] == pytest.approx(start, abs=0.03)


def test_a_goal_takes_effect_at_its_tick(controller: Controller, robot: IdealRobot) -> None:
    robot.step(controller, 10)
    assert controller.requests.place(reach("later", effective_tick=20)).start_tick == 20
    robot.step(controller, 10)
    assert controller.take_events() == []
    robot.step(controller)
    assert [event.state for event in controller.take_events()] == ["accepted", "moving"]
    assert controller.snapshot().goal_id == "later"


def test_goals_before_the_first_state_are_refused(controller: Controller) -> None:
    with pytest.raises(GoalRefusedError, match="no state"):
        controller.requests.place(reach("early"))


def test_stop_holds_and_resume_goes_on_from_there(
    controller: Controller, robot: IdealRobot
) -> None:
    robot.step(controller, 220)
    controller.requests.place(reach("g"))
    robot.step(controller, 160)
    robot.mode = "stopped"
    held = robot.command.copy()
    desired = controller.retargeting.state.q.copy()
    for _ in range(20):
        np.testing.assert_array_equal(robot.step(controller).position, held)
    np.testing.assert_array_equal(controller.retargeting.state.q, desired)
    assert controller.snapshot().phase == "stopped"
    assert controller.take_events()[-1].state == "aborted"
    with pytest.raises(GoalRefusedError, match="stopped"):
        controller.requests.place(reach("during"))
    robot.mode = "holding"
    previous = held
    for _ in range(240):
        answer = robot.step(controller).position
        assert np.abs(answer - previous).max() < 1e-2
        previous = answer
    controller.requests.place(reach("after"))
    robot.step(controller, 600)
    assert "reached" in [event.state for event in controller.take_events()]


def test_a_freeze_holds_before_the_driver_knows(controller: Controller, robot: IdealRobot) -> None:
    robot.step(controller, 220)
    controller.requests.place(reach("g"))
    robot.step(controller, 100)
    held = robot.command.copy()
    controller.freeze("red button")
    np.testing.assert_array_equal(robot.step(controller, 3).position, held)
    assert "red button" in controller.snapshot().message
    robot.mode = "stopped"
    robot.step(controller, 3)
    robot.mode = "holding"
    robot.step(controller, 3)
    assert controller.snapshot().phase != "stopped"


def test_a_command_that_is_not_ours_is_taken_up_smoothly(
    controller: Controller, robot: IdealRobot
) -> None:
    robot.step(controller, 220)
    robot.command = robot.command + 0.05
    before = robot.command.copy()
    np.testing.assert_allclose(robot.step(controller).position, before, atol=1e-3)


def test_a_sensor_that_reads_nan_does_not_move_the_robot(
    controller: Controller, robot: IdealRobot
) -> None:
    robot.step(controller, 220)
    robot.position = np.full_like(robot.command, np.nan)
    answer = robot.step(controller, 10)
    assert np.isfinite(answer.position).all()


def test_two_goals_in_one_tick_move_one_hand(controller: Controller, robot: IdealRobot) -> None:
    robot.step(controller, 10)
    other = msgspec.structs.replace(
        reach("second", effective_tick=15),
        end_effector="right_hand",
        point=np.array([0.5, -0.3, 0.95]),
    )
    controller.requests.place(reach("first", effective_tick=15))
    controller.requests.place(other)
    robot.step(controller, 10)
    ends = [(event.goal_id, event.state) for event in controller.take_events()]
    assert sorted(ends) == [("first", "accepted"), ("first", "moving"), ("second", "aborted")]


def test_a_reaching_hand_can_be_released(controller: Controller, robot: IdealRobot) -> None:
    robot.step(controller, 220)
    controller.requests.place(reach("g"))
    robot.step(controller, 800)
    controller.requests.release(ReleaseGoal(goal_id="r", end_effector="left_hand"))
    robot.step(controller, 1000)
    assert controller.take_events()[-1].state == "released"
    assert controller.snapshot().phase == "hold"


def test_the_same_states_give_the_same_bits(description: RobotDescription) -> None:
    answers = []
    for _ in range(2):
        robot, controller = IdealRobot(description), Controller(description)
        robot.step(controller, 50)
        controller.requests.place(reach("g", effective_tick=60))
        answers.append(np.stack([robot.step(controller).position for _ in range(60)]))
    np.testing.assert_array_equal(answers[0], answers[1])


def test_a_robot_that_cannot_stand_is_not_taken_over(
    controller: Controller, robot: IdealRobot, description: RobotDescription
) -> None:
    names = [joint.name for joint in description.joints]
    for side in ("left", "right"):
        robot.command[names.index(f"leg_{side}_5_joint")] += 0.5
    robot.lean(np.zeros(3))
    with pytest.raises(ControlError, match="cannot stand"):
        controller.tick(robot.state())
    with pytest.raises(GoalRefusedError):
        controller.requests.place(reach("g"))


def test_a_robot_that_leans_already_is_held_until_an_operator_says_go_on(
    controller: Controller, robot: IdealRobot
) -> None:
    robot.lean(np.array([0.0, 0.0, 40.0]))
    before = robot.command.copy()
    for _ in range(10):
        np.testing.assert_array_equal(robot.step(controller).position, before)
    snapshot = controller.snapshot()
    assert snapshot.phase == "held"
    assert "right hand 40 N" in snapshot.message
    assert "w2c resume" in snapshot.message
    with pytest.raises(GoalRefusedError):
        controller.requests.place(reach("g"))
    controller.resume()
    np.testing.assert_allclose(robot.step(controller).position, before, atol=1e-4)
    assert controller.snapshot().in_contact == (True, True, False, True)
    robot.step(controller, 40)
    assert controller.retargeting.failures == 0
    assert controller.snapshot().desired_forces[3, 2] > 0.0
