"""A process that publishes a robot's state and a log, numbered, until it is stopped.

Run as: python chatter.py ROBOT ROUTER
"""

import sys

import numpy as np

from w2c import topics
from w2c.bus.zenoh_bus import connect
from w2c.config import ServiceConfig
from w2c.messages import LogRecord, RobotState
from w2c.service import stop_on_signals

JOINTS = 25
PERIOD_S = 0.005


def robot_state(tick: int) -> RobotState:
    """Return a state of the size that a robot's has."""
    zeros = np.zeros(JOINTS)
    return RobotState(
        stamp_ns=tick * 5_000_000,
        tick=tick,
        position=zeros,
        velocity=zeros,
        torque=zeros,
        sole_wrenches=np.zeros((2, 6)),
        left_wrist_wrench=np.zeros(6),
        imu_orientation=np.array([0.0, 0.0, 0.0, 1.0]),
        imu_angular_velocity=np.zeros(3),
        imu_linear_acceleration=np.zeros(3),
        command=zeros,
        command_tick=-1,
        mode="holding",
    )


def main(robot: str, router: str) -> None:
    """Publish until SIGTERM."""
    stop = stop_on_signals()
    config = ServiceConfig(robot=robot, router=router)
    with connect(config, "robot", [router]) as bus:
        tick = 0
        while not stop.wait(PERIOD_S):
            bus.publish(topics.ROBOT_STATE, robot_state(tick))
            record = LogRecord(stamp_ns=tick, level="info", logger="chatter", text=str(tick))
            bus.publish(topics.LOG, record)
            tick += 1


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
