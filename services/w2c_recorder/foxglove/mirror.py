"""From recorded messages to what Foxglove and Rerun show of them."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.JointState_pb2 import JointState
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3

from w2c import messages as m
from w2c import topics
from w2c.errors import GeometryError, MessageError
from w2c.geometry import (
    Matrix,
    apply,
    base_from_midfeet,
    inverse,
    rotation_from_quaternion,
    transform,
)
from w2c_recorder.foxglove.cloud import cloud_of
from w2c_recorder.foxglove.marks import annotations, robot_scene, target_scene
from w2c_recorder.foxglove.protocol import Shown, timestamp
from w2c_recorder.foxglove.tree import LinkTree, quaternions
from w2c_recorder.reading import decode_call, decode_payload, topic_of

WORLD = "world"
MOTION_PERIOD_NS = 99_000_000
"""Of joint states and transforms: every state is in the raw channels, and a recorder that draws
more of them takes a noticeable part of a core"""
ALL_LINKS_PERIOD_NS = 1_000_000_000
"""Of links that do not move against their parents"""

_LEVELS = {
    "debug": Log.DEBUG,
    "info": Log.INFO,
    "warning": Log.WARNING,
    "error": Log.ERROR,
    "critical": Log.FATAL,
}


class Mirror:
    """Repeats images, transforms, joint states, logs and targets. Remembers the robot's shape.

    What it is given may be anything that was on the bus: what does not decode is not repeated.
    """

    def __init__(self) -> None:
        self._joints: list[str] = []
        self._soles: tuple[str, str] = ("", "")
        self._tree: LinkTree | None = None
        self._world_from_sole: Matrix | None = None
        self._last_motion_ns = -MOTION_PERIOD_NS
        self._last_all_ns = -ALL_LINKS_PERIOD_NS
        self.problem = ""
        """Why nothing moves, for people; empty where all is well"""
        self._show: dict[topics.Topic[Any], Callable[[Any, int, str], Iterator[Shown]]] = {
            topics.ROBOT_STATE: self._state,
            topics.CONTROLLER_STATUS: self._status,
            topics.CAMERA_FRAME: self._frame,
            topics.TARGET: self._target,
            topics.LOG: self._log,
        }

    def shown(self, key: str, payload: bytes, time_ns: int) -> Iterator[Shown]:
        """Yield what is shown of one message.

        Args:
            key: under which it was sent.
            payload: its bytes, with the envelope.
            time_ns: when it was sent [ns since 1970].
        """
        row = topic_of(key)
        if row is None or not self._wants(row, payload, time_ns):
            return
        envelope, message, _ = decode_payload(payload, row.message)
        if envelope is None or message is None:
            return
        if isinstance(message, m.CallTrace):
            self._learn(message)
        elif row in self._show:
            try:
                yield from self._show[row](message, time_ns, envelope.sender)
            except (
                GeometryError,
                MessageError,
            ) as error:  # a sensor or a sender that tells nonsense
                self.problem = f"{key}: {error}"

    def _wants(self, row: topics.Topic[Any], payload: bytes, time_ns: int) -> bool:
        """Tell whether it is worth the time to decode a message."""
        if row is topics.ROBOT_STATE:
            due = not 0 <= time_ns - self._last_motion_ns < MOTION_PERIOD_NS
            return due and bool(self._joints)
        if row is topics.TRACE:  # which call it is stands in front of what was said
            return b"describe" in payload[:400]
        return row in self._show

    def _learn(self, trace: m.CallTrace) -> None:
        """Take the shape of the robot from a call that asked for it."""
        if (trace.service, trace.method) != (topics.DESCRIBE.service, topics.DESCRIBE.name):
            return
        reply = decode_call(trace)[1]
        if not isinstance(reply, m.RobotDescription):
            return
        self._joints = [joint.name for joint in reply.joints]
        self._soles = reply.sole_frames
        try:
            self._tree, self.problem = LinkTree(reply.urdf, self._joints), ""
        except GeometryError as error:
            self._tree, self.problem = None, str(error)

    def _state(self, state: m.RobotState, time_ns: int, _sender: str) -> Iterator[Shown]:
        if len(state.position) != len(self._joints) or not np.isfinite(state.position).all():
            return
        self._last_motion_ns = time_ns
        joints = [
            JointState(
                name=name,
                position=float(state.position[index]),
                velocity=float(state.velocity[index]),
                effort=float(state.torque[index]),
            )
            for index, name in enumerate(self._joints)
        ]
        yield Shown("joints", JointStates(timestamp=timestamp(time_ns), joints=joints))
        if self._tree is not None:
            yield from self._motion(self._tree, state.position, time_ns)

    def _motion(self, tree: LinkTree, angles: Matrix, time_ns: int) -> Iterator[Shown]:
        """Yield where the links are, and lines between them: a robot without meshes."""
        parent_from_child = tree.parent_from_child(angles)
        root_from_links = tree.root_from_links(parent_from_child)
        world_from_root = self._world_from_root(root_from_links)
        if world_from_root is None:
            return
        all_due = not 0 <= time_ns - self._last_all_ns < ALL_LINKS_PERIOD_NS
        if all_due:
            self._last_all_ns = time_ns
        parents, children = [WORLD, *tree.parents], [tree.root, *tree.children]
        transforms = np.concatenate([world_from_root[np.newaxis], parent_from_child])
        sent = np.flatnonzero([True, *(moves or all_due for moves in tree.moves)])
        orientations = quaternions(transforms[sent, :3, :3]).tolist()
        positions = transforms[sent, :3, 3].tolist()
        stamp = timestamp(time_ns)
        found = [
            FrameTransform(
                timestamp=stamp,
                parent_frame_id=parents[number],
                child_frame_id=children[number],
                translation=Vector3(x=x, y=y, z=z),
                rotation=Quaternion(x=qx, y=qy, z=qz, w=qw),
            )
            for number, (x, y, z), (qx, qy, qz, qw) in zip(
                sent.tolist(), positions, orientations, strict=True
            )
        ]
        yield Shown("tf", FrameTransforms(transforms=found))
        ends = np.array(
            [
                (root_from_links[parent][:3, 3], root_from_links[child][:3, 3])
                for parent, child in zip(tree.parents, tree.children, strict=True)
            ]
        )
        yield Shown("robot", robot_scene(apply(world_from_root, ends), WORLD, time_ns))

    def _world_from_root(self, root_from_links: dict[str, Matrix]) -> Matrix | None:
        """Return the pose of the base: as the controller means it, else between the soles."""
        left, right = (root_from_links.get(name) for name in self._soles)
        if left is None or right is None:
            self.problem = f"the description has no links {self._soles}: the robot is not shown"
            return None
        if self._world_from_sole is not None:
            return self._world_from_sole @ inverse(left)
        return inverse(base_from_midfeet(left, right))

    def _status(self, status: m.ControllerStatus, _time_ns: int, _sender: str) -> Iterator[Shown]:
        if status.soles is not None:
            left = status.soles[0]
            self._world_from_sole = transform(rotation_from_quaternion(left[3:]), left[:3])
        yield from ()

    def _frame(self, frame: m.CameraFrame, time_ns: int, _sender: str) -> Iterator[Shown]:
        stamp = timestamp(time_ns)
        image = CompressedImage(
            timestamp=stamp, frame_id=frame.frame, data=frame.jpeg, format="jpeg"
        )
        yield Shown("camera/image", image)
        fx, fy, cx, cy = frame.intrinsics
        calibration = CameraCalibration(
            timestamp=stamp,
            frame_id=frame.frame,
            width=frame.width,
            height=frame.height,
            K=[fx, 0, cx, 0, fy, cy, 0, 0, 1],
            R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
            P=[fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0],
        )
        yield Shown("camera/calibration", calibration)
        cloud = cloud_of(frame, time_ns)
        if cloud is not None:
            yield Shown("camera/cloud", cloud)

    def _target(self, target: m.Target, time_ns: int, _sender: str) -> Iterator[Shown]:
        yield Shown("camera/target", annotations(target, time_ns))
        if target.point is not None:
            yield Shown("target", target_scene(target, WORLD, time_ns))

    def _log(self, record: m.LogRecord, time_ns: int, sender: str) -> Iterator[Shown]:
        line = Log(
            timestamp=timestamp(time_ns),
            level=_LEVELS.get(record.level.lower(), Log.UNKNOWN),
            message=record.text,
            name=f"{sender}: {record.logger}",
        )
        yield Shown("log", line)
