"""A robot with two legs, and a session that tells its shape."""

import numpy as np

from support.sessions import Session, conversation
from w2c import messages as m
from w2c import topics

URDF = """<robot name="two_legs">
  <link name="base"/><link name="left"/><link name="right"/><link name="sole"/>
  <joint name="slide" type="prismatic">
    <origin xyz="0 0.1 0"/><parent link="base"/><child link="left"/><axis xyz="0 0 2"/>
  </joint>
  <joint name="turn" type="revolute">
    <origin xyz="0 -0.1 0" rpy="0 0 1.5707963267948966"/>
    <parent link="base"/><child link="right"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="fixed" type="fixed">
    <origin xyz="0 0 -0.9"/><parent link="left"/><child link="sole"/>
  </joint>
  <transmission><joint name="turn"/></transmission>
</robot>"""


def description(urdf: str = URDF) -> m.RobotDescription:
    joints = [m.JointInfo(name=name, stiffness=1.0, effort_limit=1.0) for name in ("slide", "turn")]
    return m.RobotDescription(
        urdf=urdf, joints=joints, sole_frames=("sole", "right"), hand_frames=("l", "r"),
        hand_radius=(0.0, 0.0), camera_frame="camera", initial_position=np.zeros(2),
        period_ns=2_000_000, lock_step=True,
    )  # fmt: skip


def robot_session(urdf: str = URDF) -> Session:
    """Return the conversation of the tests with a robot that was described in the beginning."""
    told = conversation()
    told.call(0.1, topics.DESCRIBE, m.Empty(), description(urdf), caller="controller")
    told.add(0.2, topics.LOG, m.LogRecord(stamp_ns=0, level="warning", logger="a", text="slow"),
             sender="llm")  # fmt: skip
    shown = m.Target(
        target_id="t", frame_stamp_ns=1, u=10.0, v=20.0, point=np.array([0.5, 0.0, 0.8]),
        normal=np.array([0.0, 0.0, 1.0]), state="proposed", phrases=["mug"],
        boxes=[m.Box(left=1.0, top=2.0, right=3.0, bottom=4.0, score=0.5)],
    )  # fmt: skip
    told.add(1.0, topics.TARGET, shown)
    return told
