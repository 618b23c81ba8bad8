"""Simulated robots for studies: perturbed, and with something plain before them to push on."""

from dataclasses import dataclass
from xml.etree import ElementTree  # made by make_urdf; nobody else's XML is read here

import mujoco
import numpy as np

from w2c.messages import RobotDescription
from w2c_sim_robot import talos
from w2c_sim_robot.description import make_description
from w2c_sim_robot.model import WORLD_CONAFFINITY, WORLD_CONTYPE, build_spec, compile_spec
from w2c_sim_robot.perturbation import Perturbation
from w2c_sim_robot.physics import Simulator
from w2c_sim_robot.sensor_errors import SensorErrors
from w2c_sim_robot.urdf import make_urdf


@dataclass(frozen=True)
class Block:
    """A box that does not move: a table's top, a wall."""

    centre: tuple[float, float, float]
    """In the world [m]"""
    half_size: tuple[float, float, float]
    """[m]"""


def study_robot(
    perturbation: Perturbation | None = None,
    blocks: tuple[Block, ...] = (),
    *,
    description: RobotDescription | None = None,
    sensors: SensorErrors | None = None,
    generator: np.random.Generator | None = None,
) -> Simulator:
    """Return a robot that stands ready, without what is only looked at.

    Args:
        perturbation: what its description does not tell; None = nothing.
        blocks: what stands before it.
        description: of the robot, nominal; None makes it.
        sensors: how they err; None = not at all.
        generator: seeded, for sensors that err, and for nothing else.
    """
    perturbation = perturbation or Perturbation()
    spec = build_spec()
    for index, block in enumerate(blocks):
        x, y, z = block.centre
        spec.worldbody.add_geom(
            name=f"block_{index}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=(x, y, z + perturbation.table_height),
            size=block.half_size,
            contype=WORLD_CONTYPE,
            conaffinity=WORLD_CONAFFINITY,
        )
    return Simulator(
        compile_spec(spec, perturbation, visuals=False),
        description or make_description(lock_step=True),
        sensors=sensors,
        generator=generator,
        left_hand_mass=perturbation.hand_mass[0],
    )


def loaded_description(hand_mass: tuple[float, float]) -> RobotDescription:
    """Return the description of a robot whose hands hold these point masses, left and right [kg].

    For finding what the loaded robot can do. The controller under test gets the nominal one.
    """
    root = ElementTree.fromstring(make_urdf())  # noqa: S314 - made by us
    links = {link.get("name"): link for link in root.findall("link")}
    for frame, mass in zip(talos.HAND_FRAMES, hand_mass, strict=True):
        if mass == 0.0:
            continue
        link = links[frame]
        inertial = link.find("inertial")
        if inertial is None:
            inertial = ElementTree.SubElement(link, "inertial")
            ElementTree.SubElement(inertial, "mass", value="0")
            ElementTree.SubElement(
                inertial, "inertia", ixx="1e-3", iyy="1e-3", izz="1e-3", ixy="0", ixz="0", iyz="0"
            )
        element = inertial.find("mass")
        if element is not None:
            element.set("value", repr(float(element.get("value", "0")) + mass))
    return make_description(lock_step=True, urdf=ElementTree.tostring(root, encoding="unicode"))
