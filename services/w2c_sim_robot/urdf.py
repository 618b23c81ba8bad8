"""From the URDF in the example-robot-data wheel to the robot that is controlled and simulated.

One string feeds both Pinocchio and MuJoCo, so that their masses and frames cannot differ. It is
made at run time and stays in memory: the licence statements of the wheel's files contradict each
other.
"""

import re
import sys
from pathlib import Path
from xml.etree import ElementTree  # the wheel's own file; nobody else's XML is read here

from w2c.errors import ConfigError
from w2c_sim_robot import talos

_ROBOTS = Path("cmeel.prefix/share/example-robot-data/robots")
_SOURCE = Path("talos_data/robots/talos_reduced.urdf")
_SEMANTICS = Path("talos_data/srdf/talos.srdf")
_PACKAGE = re.compile(r"package:/{2,3}example-robot-data/robots/")
_PRETTY_ARM = {
    **{f"arm_{i}_collision.STL": f"arm_{i}.stl" for i in range(1, 7)},
    "arm_7_collision.STL": "arm_7.STL",
}
_FOOT_HEIGHT = 0.04

Element = ElementTree.Element


def robots_directory(search_path: list[str] | None = None) -> Path:
    """Return the folder of the example-robot-data wheel that holds the robots.

    Raises:
        ConfigError: the wheel is not installed, or has no Talos.
    """
    for entry in sys.path if search_path is None else search_path:
        directory = Path(entry) / _ROBOTS
        if (directory / _SOURCE).is_file():
            return directory
    raise ConfigError(
        "the model of Talos is missing: no example-robot-data wheel on the Python path. "
        "Run: pip install -c constraints.txt -e '.[sim-robot]'"
    )


def overlapping_links(robots: Path | None = None) -> frozenset[frozenset[str]]:
    """Return the pairs of links whose shapes always overlap, as the robot's maker says.

    They are neighbours, or next to neighbours: their joints keep the true parts apart.

    Raises:
        ConfigError: the wheel is not installed, or has no list of such pairs.
    """
    source = (robots or robots_directory()) / _SEMANTICS
    try:
        rows = ElementTree.parse(source).getroot().findall("disable_collisions")  # noqa: S314
    except (OSError, ElementTree.ParseError) as error:
        raise ConfigError(f"which links of Talos overlap is not known: {error}") from error
    return frozenset(
        frozenset((row.get("link1", ""), row.get("link2", "")))
        for row in rows
        if row.get("reason") in ("Adjacent", "Default")
    )


def make_urdf(robots: Path | None = None) -> str:
    """Return the URDF of the robot: 27 actuated joints, ball-ended right forearm, gripper locked.

    Raises:
        ConfigError: the wheel is missing, or its file is not the Talos that this code knows.
    """
    path = (robots or robots_directory()) / _SOURCE
    try:
        root = ElementTree.fromstring(path.read_text())  # noqa: S314 - installed by pip, as this code is
    except (OSError, ElementTree.ParseError) as error:
        raise ConfigError(
            f"{path} cannot be read: {error}; reinstall example-robot-data"
        ) from error
    _drop_simulator_tags(root)
    _prune(root, "arm_right_6_joint")
    for name in ("arm_right_5_joint", "gripper_left_joint"):
        _lock(root, name)
    _add_ball(root)
    _add_frame(root, "left_hand_frame", "arm_left_7_link", talos.LEFT_HAND_OFFSET)
    _use_box_feet(root)
    _set_efforts(root)
    _draw_arms_nicely(root)
    return ElementTree.tostring(root, encoding="unicode")


def mujoco_urdf(urdf: str, robots: Path | None = None) -> str:
    """Return the URDF with mesh paths and the compiler options that MuJoCo needs.

    Static links stay bodies (sensors and frames live on them), and visual geometry is kept.
    """
    compiler = (
        f'<mujoco><compiler meshdir="{robots or robots_directory()}" strippath="false" '
        'fusestatic="false" discardvisual="false" balanceinertia="false"/></mujoco>'
    )
    with_meshes = _PACKAGE.sub("", urdf)
    return re.sub(r"(<robot\b[^>]*>)", lambda m: m.group(1) + compiler, with_meshes, count=1)


def _drop_simulator_tags(root: Element) -> None:
    """Keep links, joints and materials. Friction and damping would hide the joint's stiffness."""
    for child in list(root):
        if child.tag not in ("link", "joint", "material"):
            root.remove(child)
    for joint in root.findall("joint"):
        for dynamics in joint.findall("dynamics"):
            joint.remove(dynamics)


def _find(root: Element, tag: str, name: str) -> Element:
    for element in root.findall(tag):
        if element.get("name") == name:
            return element
    raise ConfigError(
        f"the Talos of the installed example-robot-data has no {tag} '{name}'; install version 6"
    )


def _link_of(joint: Element, end: str) -> str:
    element = joint.find(end)
    return "" if element is None else element.get("link", "")


def _prune(root: Element, joint_name: str) -> None:
    """Remove a joint and all that hangs on it."""
    removed = [_find(root, "joint", joint_name)]
    while removed:
        joint = removed.pop()
        link = _link_of(joint, "child")
        root.remove(joint)
        root.remove(_find(root, "link", link))
        removed += [j for j in root.findall("joint") if _link_of(j, "parent") == link]


def _lock(root: Element, joint_name: str) -> None:
    """Fix a joint at zero."""
    joint = _find(root, "joint", joint_name)
    joint.set("type", "fixed")
    for tag in ("axis", "limit"):
        for element in joint.findall(tag):
            joint.remove(element)


def _text(values: tuple[float, ...]) -> str:
    return " ".join(repr(value) for value in values)


def _add_frame(root: Element, name: str, parent: str, offset: tuple[float, ...]) -> Element:
    """Add an empty link, parallel to its parent. Returns the link."""
    _find(root, "link", parent)
    link = ElementTree.SubElement(root, "link", name=name)
    joint = ElementTree.SubElement(root, "joint", name=f"{name}_joint", type="fixed")
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=name)
    ElementTree.SubElement(joint, "origin", xyz=_text(offset), rpy="0 0 0")
    return link


def _add_shape(
    link: Element, kind: str, shape: str, centre: tuple[float, ...], size: dict[str, str]
) -> None:
    element = ElementTree.SubElement(link, kind)
    ElementTree.SubElement(element, "origin", xyz=_text(centre), rpy="0 0 0")
    ElementTree.SubElement(ElementTree.SubElement(element, "geometry"), shape, size)


def _add_ball(root: Element) -> None:
    """End the right forearm in a ball on a rod; the frame of the hand is the ball's centre."""
    link = _add_frame(root, "right_hand_frame", "arm_right_5_link", talos.BALL_OFFSET)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz="0 0 0", rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=repr(talos.BALL_MASS))
    moment = repr(0.4 * talos.BALL_MASS * talos.BALL_RADIUS**2)  # of a solid sphere
    ElementTree.SubElement(
        inertial, "inertia", ixx=moment, iyy=moment, izz=moment, ixy="0", ixz="0", iyz="0"
    )
    radius = repr(talos.BALL_RADIUS)
    _add_shape(link, "visual", "sphere", (0.0, 0.0, 0.0), {"radius": radius})
    length = -talos.BALL_OFFSET[2]
    rod = {"radius": "0.022", "length": repr(length)}
    _add_shape(link, "visual", "cylinder", (0.0, 0.0, length / 2), rod)
    _add_shape(link, "collision", "sphere", (0.0, 0.0, 0.0), {"radius": radius})


def _use_box_feet(root: Element) -> None:
    """Give the sole links the boxes that touch: a sensor there feels the floor, not the foot."""
    length, width = talos.SOLE_HALF_SIZE
    size = _text((2 * length, 2 * width, _FOOT_HEIGHT))
    for side in ("left", "right"):
        foot = _find(root, "link", f"leg_{side}_6_link")
        for collision in foot.findall("collision"):
            foot.remove(collision)
        sole = _find(root, "link", f"{side}_sole_link")
        _add_shape(sole, "collision", "box", (0.0, 0.0, _FOOT_HEIGHT / 2), {"size": size})


def _set_efforts(root: Element) -> None:
    for name, effort in talos.EFFORT.items():
        limit = _find(root, "joint", name).find("limit")
        if limit is None:
            raise ConfigError(f"joint '{name}' of the installed Talos has no limits")
        limit.set("effort", repr(effort))


def _draw_arms_nicely(root: Element) -> None:
    """Show the arms' covers: the wheel's reduced model draws their collision meshes."""
    for mesh in root.findall("link/visual/geometry/mesh"):
        path, _, name = mesh.get("filename", "").rpartition("/")
        if name in _PRETTY_ARM:
            mesh.set("filename", f"{path}/{_PRETTY_ARM[name]}")
