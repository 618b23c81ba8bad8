"""How the simulated robot differs from its description, which stays nominal."""

from dataclasses import dataclass
from math import cos, radians, sin
from typing import TYPE_CHECKING

import msgspec
import mujoco
import numpy as np

from w2c.errors import ConfigError
from w2c.messages import Array
from w2c_sim_robot import talos

if TYPE_CHECKING:
    from w2c_sim_robot.scenes.scene import Scene, SceneObject

_FACTORS = ("stiffness", "friction", "ball_friction", "mass")
_HEAVIEST_HAND = 50.0
_STEEPEST_TILT = radians(10.0)
_HIGHEST_RISE = 0.2
_ON_THE_FLOOR = 0.01


@dataclass(frozen=True)
class Perturbation:
    """What the controller is not told. Factors: 1 = as described; pairs: left, right."""

    stiffness: float = 1.0
    friction: float = 1.0
    ball_friction: float = 1.0
    """Of the ball-ended hand alone, beside `friction`: something slippery under it"""
    mass: float = 1.0
    hand_mass: tuple[float, float] = (0.0, 0.0)
    """Point masses held at the hand frames [kg]"""
    sole_pitch: tuple[float, float] = (0.0, 0.0)
    """Of the bottom of each sole against its frame, toes down, about its front edge [rad]:
    a wedge under the foot; negative, heel down, about its rear edge"""
    table_height: float = 0.0
    """How much higher everything before the robot stands than its scene says [m]; not what is
    loose on the floor. The camera draws fixed things where the scene has them."""

    def __post_init__(self) -> None:
        """Refuse what is no robot any more."""
        for name in _FACTORS:
            value = getattr(self, name)
            if not 0.05 <= value <= 20.0:
                raise ConfigError(f"{name} scale {value:g} is outside 0.05 to 20; 1 is nominal")
        for mass in self.hand_mass:
            if not 0.0 <= mass <= _HEAVIEST_HAND:
                raise ConfigError(f"hand mass {mass:g} kg is outside 0 to {_HEAVIEST_HAND:g} kg")
        for pitch in self.sole_pitch:
            if not abs(pitch) <= _STEEPEST_TILT:
                raise ConfigError(
                    f"sole pitch {pitch:g} rad is beyond {_STEEPEST_TILT:.3f} rad: no floor is that"
                )
        if not abs(self.table_height) <= _HIGHEST_RISE:
            raise ConfigError(
                f"table height {self.table_height:g} m is beyond {_HIGHEST_RISE:g} m: "
                "for another table write another scene"
            )


def raise_scene(scene: "Scene", height: float) -> "Scene":
    """Return the scene with everything higher [m], but for what is loose on the floor."""

    def raised(item: "SceneObject") -> "SceneObject":
        x, y, z = item.position
        if item.movable and z < _ON_THE_FLOOR:
            return item
        return msgspec.structs.replace(item, position=(x, y, z + height))

    return msgspec.structs.replace(scene, objects=tuple(map(raised, scene.objects)))


def tilt_soles(spec: mujoco.MjSpec, perturbation: Perturbation) -> None:
    """Tilt the boxes that touch the floor. The edge that they turn about stays where it was."""
    half_length = talos.SOLE_HALF_SIZE[0]
    for frame, pitch in zip(talos.SOLE_FRAMES, perturbation.sole_pitch, strict=True):
        if pitch == 0.0:
            continue
        (box,) = (geom for geom in spec.body(frame).geoms if geom.contype)
        edge = half_length if pitch > 0 else -half_length
        x, y, z = box.pos
        x -= edge
        box.pos = (edge + cos(pitch) * x + sin(pitch) * z, y, cos(pitch) * z - sin(pitch) * x)
        box.quat = (cos(pitch / 2), 0.0, sin(pitch / 2), 0.0)


def perturb(model: mujoco.MjModel, perturbation: Perturbation) -> None:
    """Change stiffness, friction and masses of a compiled model."""
    model.actuator_gainprm[:, 0] *= perturbation.stiffness
    model.actuator_biasprm[:, 1:3] *= perturbation.stiffness
    robot = _robot_bodies(model)
    model.body_mass[robot] *= perturbation.mass
    model.body_inertia[robot] *= perturbation.mass
    model.geom_friction[robot[model.geom_bodyid]] *= perturbation.friction
    ball = model.geom_bodyid == model.body(talos.HAND_FRAMES[1]).id
    model.geom_friction[ball] *= perturbation.ball_friction
    for frame, mass in zip(talos.HAND_FRAMES, perturbation.hand_mass, strict=True):
        hand = model.body(frame).id
        model.body_mass[hand] += mass
        model.body_inertia[hand] += 0.4 * mass * talos.BALL_RADIUS**2
    mujoco.mj_setConst(model, mujoco.MjData(model))


def _robot_bodies(model: mujoco.MjModel) -> Array:
    """Return (nbody,) booleans: which bodies are part of the robot."""
    return np.asarray(model.body_rootid == model.body(talos.BASE_LINK).id)
