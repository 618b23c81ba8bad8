"""What the robot driver tells a controller about the robot."""

from w2c.messages import JointInfo, RobotDescription
from w2c_sim_robot import talos
from w2c_sim_robot.urdf import make_urdf

TICK_NS = 2_000_000
"""Period of states and commands [ns]."""


def make_description(*, lock_step: bool = False, urdf: str | None = None) -> RobotDescription:
    """Return the description of the simulated Talos, always the nominal one.

    Args:
        lock_step: whether the robot waits for the command of each tick.
        urdf: the model, where the caller has made it already.

    Raises:
        ConfigError: the example-robot-data wheel is not installed.
    """
    joints = [
        JointInfo(name=name, stiffness=talos.STIFFNESS[name], effort_limit=talos.EFFORT[name])
        for name in talos.ACTUATED
    ]
    return RobotDescription(
        urdf=urdf or make_urdf(),
        joints=joints,
        sole_frames=talos.SOLE_FRAMES,
        hand_frames=talos.HAND_FRAMES,
        hand_radius=(0.0, talos.BALL_RADIUS),
        camera_frame=talos.CAMERA_FRAME,
        initial_position=talos.ready_position(),
        period_ns=TICK_NS,
        lock_step=lock_step,
    )
