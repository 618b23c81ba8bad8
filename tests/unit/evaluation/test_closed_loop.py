"""The studies' loop is the product's: bit by bit what robot and controller do over the bus."""

import threading

import numpy as np

from w2c import topics
from w2c.bus.inprocess import InProcessHub
from w2c.clock import RealClock
from w2c.messages import Array, PlaceGoal, ReleaseGoal
from w2c_controller.config import ControllerConfig
from w2c_controller.controller import Controller
from w2c_controller.node import ControllerNode
from w2c_evaluation.closed_loop import ClosedLoop
from w2c_sim_robot.config import RobotConfig
from w2c_sim_robot.description import make_description
from w2c_sim_robot.node import RobotNode
from w2c_sim_robot.study import study_robot

TICKS = 900
GOAL_TICK = 600


def reach() -> PlaceGoal:
    return PlaceGoal(
        goal_id="g",
        end_effector="right_hand",
        task="reach",
        point=np.array([0.45, -0.35, 1.0]),
        normal=np.array([-1.0, 0.0, 0.0]),
        effective_tick=GOAL_TICK,
    )


def alone() -> Array:
    description = make_description(lock_step=True)
    loop = ClosedLoop(study_robot(description=description), Controller(description))
    loop.run(10)
    assert loop.ask(reach()) == ""
    loop.run(TICKS - 10)
    return np.array(loop.robot.truth().generalized_position)


def over_the_bus() -> Array:
    hub, clock = InProcessHub(), RealClock()
    buses = [hub.connect(name) for name in ("robot", "controller", "evaluation")]
    robot = RobotNode(RobotConfig(robot="test", lock_step=True, truth_every=1), buses[0], clock)
    controller = ControllerNode(ControllerConfig(robot="test"), buses[1], clock)
    truths = buses[2].queue(topics.TRUTH, size=5 * TICKS)
    robot.configure()
    controller.configure()
    stop = threading.Event()
    threads = [threading.Thread(target=node.run, args=(stop,)) for node in (controller, robot)]
    for thread in threads:
        thread.start()
    try:
        asked, position = False, np.zeros(0)
        for _ in range(TICKS + 1):
            received = truths.receive(20.0)
            assert received is not None, "the robot stopped"
            if not asked and received.message.tick >= 10:
                asked = True
                buses[2].call(topics.PLACE, reach())
            position = received.message.generalized_position
            if received.message.tick == TICKS:
                break
        return position
    finally:
        stop.set()
        for thread in threads:
            thread.join(20.0)
        robot.close()
        controller.close()
        for bus in buses:
            bus.close()


def test_bit_by_bit_what_they_do_over_the_bus() -> None:
    assert alone().tobytes() == over_the_bus().tobytes()


def test_a_refused_goal_says_why() -> None:
    description = make_description(lock_step=True)
    loop = ClosedLoop(study_robot(description=description), Controller(description))
    assert "state of the robot" in loop.ask(reach())
    loop.run(5)
    assert "at rest" in loop.ask(ReleaseGoal(goal_id="r", end_effector="right_hand"))


def test_watching_ends_it_at_once() -> None:
    description = make_description(lock_step=True)
    loop = ClosedLoop(study_robot(description=description), Controller(description))
    assert loop.run(50, watch=lambda: loop.robot.tick == 7) == ""
    assert loop.robot.tick == 7
