"""Where the links of a robot are, from its description and its joint angles. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from w2c.errors import GeometryError
from w2c.geometry import Matrix, transform

MOVING = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class _Joint:
    parent: str
    child: str
    parent_from_zero: Matrix
    """Of the child at angle zero"""
    axis_cross: Matrix
    """(3, 3) cross product with the axis; of a prismatic joint unused"""
    axis: Matrix
    """(3,) in the frame of the child"""
    kind: str
    index: int
    """In the joint vector; -1 = does not move, or nobody tells its angle"""


class LinkTree:
    """The tree of links of a URDF.

    The root has no parent in the description; its pose in the world comes from elsewhere.
    """

    def __init__(self, urdf: str, joint_names: Sequence[str]) -> None:
        """Read a description.

        Args:
            urdf: the text.
            joint_names: of the joint vector, in its order.

        Raises:
            GeometryError: the text is no URDF, or its links make no tree.
        """
        numbers = {name: index for index, name in enumerate(joint_names)}
        if "<!" in urdf.replace("<!--", ""):
            # Entities can grow without bound while they are read, and no robot needs them.
            raise GeometryError("the robot's description declares entities; a URDF has none")
        try:
            root = ElementTree.fromstring(urdf)  # noqa: S314 - without declarations it is harmless
            joints = [_joint(element, numbers) for element in root.iter("joint") if len(element)]
        except (ElementTree.ParseError, ValueError) as error:
            raise GeometryError(f"the robot's description is no URDF: {error}") from error
        joints, self.root = _ordered(joints)
        self.parents = [joint.parent for joint in joints]
        self.children = [joint.child for joint in joints]
        self.moves = [joint.index >= 0 for joint in joints]
        """Of each link, in the order of `children`: parents come first"""
        self._zero = np.array([joint.parent_from_zero for joint in joints]).reshape(-1, 4, 4)
        self._index = np.array([joint.index for joint in joints], dtype=np.int64)
        slides = np.array([joint.kind == "prismatic" for joint in joints], dtype=bool)
        moving = self._index >= 0
        self._turning, self._sliding = moving & ~slides, moving & slides
        self._axis = np.array([joint.axis for joint in joints]).reshape(-1, 3)
        self._cross = np.array([joint.axis_cross for joint in joints]).reshape(-1, 3, 3)
        self._cross_twice = self._cross @ self._cross
        numbered = {name: number for number, name in enumerate(self.children)}
        self._parent_number = [numbered.get(name, -1) for name in self.parents]

    def parent_from_child(self, angles: Matrix) -> Matrix:
        """Return the transforms of all links (n, 4, 4); rotations by Rodrigues' formula.

        All at once: one by one they take ten times as long, and this runs while a robot does.
        """
        angle = np.where(self._index >= 0, angles[self._index], 0.0)
        moved = np.tile(np.eye(4), (len(self._index), 1, 1))
        turning = (angle * self._turning)[:, np.newaxis, np.newaxis]
        moved[:, :3, :3] += (
            np.sin(turning) * self._cross + (1.0 - np.cos(turning)) * self._cross_twice
        )
        moved[:, :3, 3] = (angle * self._sliding)[:, np.newaxis] * self._axis
        return np.asarray(self._zero @ moved)

    def root_from_links(self, parent_from_child: Matrix) -> dict[str, Matrix]:
        """Return link -> root_from_link (4, 4), of what `parent_from_child` gave."""
        chained: list[Matrix] = []
        for own, parent in zip(parent_from_child, self._parent_number, strict=True):
            chained.append(own if parent < 0 else chained[parent] @ own)
        return {self.root: np.eye(4), **dict(zip(self.children, chained, strict=True))}


def quaternions(rotations: Matrix) -> Matrix:
    """Return the quaternions xyzw (n, 4), w >= 0, of rotations (n, 3, 3)."""
    m = rotations
    squares = np.stack(
        [
            1 + m[:, 0, 0] - m[:, 1, 1] - m[:, 2, 2],
            1 - m[:, 0, 0] + m[:, 1, 1] - m[:, 2, 2],
            1 - m[:, 0, 0] - m[:, 1, 1] + m[:, 2, 2],
            1 + m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2],
        ],
        axis=1,
    )
    sums = m + m.transpose(0, 2, 1)
    twist = m - m.transpose(0, 2, 1)
    candidates = np.empty((len(m), 4, 4))
    for row in range(3):
        candidates[:, row, :3] = sums[:, row, :]
        candidates[:, row, row] = squares[:, row]
    candidates[:, 3, 0] = candidates[:, 0, 3] = twist[:, 2, 1]
    candidates[:, 3, 1] = candidates[:, 1, 3] = twist[:, 0, 2]
    candidates[:, 3, 2] = candidates[:, 2, 3] = twist[:, 1, 0]
    candidates[:, 3, 3] = squares[:, 3]
    # All four are the same in exact arithmetic; that of the largest divisor is the accurate one.
    chosen = candidates[np.arange(len(m)), np.argmax(squares, axis=1)]
    chosen = chosen / np.linalg.norm(chosen, axis=1, keepdims=True)
    return np.asarray(np.where(chosen[:, 3:] >= 0.0, chosen, -chosen))


def _joint(element: ElementTree.Element, numbers: dict[str, int]) -> _Joint:
    name, kind = element.get("name", ""), element.get("type", "")
    parent, child = element.find("parent"), element.find("child")
    if parent is None or child is None:
        raise ValueError(f"joint '{name}' has no parent or no child")
    axis_element, origin = element.find("axis"), element.find("origin")
    axis = _numbers(axis_element, "xyz", (1.0, 0.0, 0.0))
    length = float(np.linalg.norm(axis))
    axis = axis / length if length > 0.0 else axis
    x, y, z = axis
    return _Joint(
        parent=parent.get("link", ""),
        child=child.get("link", ""),
        parent_from_zero=transform(
            _rotation(_numbers(origin, "rpy", (0.0, 0.0, 0.0))),
            _numbers(origin, "xyz", (0.0, 0.0, 0.0)),
        ),
        axis_cross=np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]),
        axis=axis,
        kind=kind,
        index=numbers.get(name, -1) if kind in MOVING else -1,
    )


def _numbers(element: ElementTree.Element | None, name: str, default: Sequence[float]) -> Matrix:
    text = None if element is None else element.get(name)
    values = np.array(default if text is None else [float(word) for word in text.split()])
    if values.shape != (3,) or not np.isfinite(values).all():
        raise ValueError(f'{name}="{text}" is not three numbers')
    return values


def _rotation(rpy: Matrix) -> Matrix:
    """Return the rotation of fixed-axis roll, pitch, yaw [rad], as URDF means them."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def _ordered(joints: list[_Joint]) -> tuple[list[_Joint], str]:
    """Return the joints parents first, and the root. Raises GeometryError: they make no tree."""
    children = {joint.child for joint in joints}
    roots = sorted({joint.parent for joint in joints} - children)
    if len(roots) != 1 or len(children) != len(joints):
        raise GeometryError(f"the robot's description is no tree: its roots are {roots}")
    by_parent: dict[str, list[_Joint]] = {}
    for joint in joints:
        by_parent.setdefault(joint.parent, []).append(joint)
    ordered: list[_Joint] = []
    pending = [roots[0]]
    while pending:
        for joint in by_parent.get(pending.pop(), []):
            ordered.append(joint)
            pending.append(joint.child)
    if len(ordered) != len(joints):
        raise GeometryError("the robot's description is no tree: some links hang on each other")
    return ordered, roots[0]
