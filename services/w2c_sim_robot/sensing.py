"""What the simulated robot's sensors read, and who touches what, from MuJoCo's state."""

from dataclasses import dataclass

import mujoco
import numpy as np

from w2c.errors import ConfigError
from w2c.messages import Array
from w2c_sim_robot import talos

Numbers = list[float]

_WORLD, _BODY = -1, -2  # beside the indices of the four end effectors


@dataclass(frozen=True)
class Noise:
    """Standard deviations of what is added to each reading; zero = ideal sensors."""

    position: float = 0.0
    """[rad]"""
    velocity: float = 0.0
    """[rad/s]"""
    torque: float = 0.0
    """[Nm]"""
    force: float = 0.0
    """[N]"""
    moment: float = 0.0
    """Of the force-torque sensors [Nm]"""
    angular_velocity: float = 0.0
    """[rad/s]"""
    acceleration: float = 0.0
    """[m/s^2]"""

    @staticmethod
    def typical(scale: float) -> "Noise":
        """Return the noise of ordinary sensors times `scale`. Raises ConfigError below zero."""
        if not 0.0 <= scale <= 100.0:
            raise ConfigError(f"noise scale {scale:g} is outside 0 to 100; 1 is ordinary sensors")
        return Noise(
            position=2e-5 * scale,
            velocity=5e-3 * scale,
            torque=0.5 * scale,
            force=1.0 * scale,
            moment=0.05 * scale,
            angular_velocity=2e-3 * scale,
            acceleration=2e-2 * scale,
        )


class ForceTorqueSensor:
    """Between a link and its parent: what the environment exerts on all that hangs on the link.

    In plain numbers: for three of them numpy's overhead is four times the arithmetic.
    """

    def __init__(
        self, model: mujoco.MjModel, name: str, link: str, frame: str, *, unknown: float = 0.0
    ) -> None:
        """Find a sensor.

        Args:
            model: with the sensor's site, force and torque.
            name: of these three.
            link: whose weight is subtracted, with all that hangs on it.
            frame: where the wrench is given.
            unknown: mass at this frame that is not subtracted, because nobody knows of it [kg].
        """
        self._force = sensor_slice(model, f"{name}_force")
        self._torque = sensor_slice(model, f"{name}_torque")
        self._link = model.body(link).id
        self._frame = model.body(frame).id
        self._site = model.site(name).id
        self._weight = (model.body_subtreemass[self._link] * model.opt.gravity).tolist()
        """In the world (3,) [N]"""
        self._unknown = (unknown * model.opt.gravity).tolist()

    def read(self, data: mujoco.MjData) -> Array:
        """Return the wrench (6,), force then torque, in and at the frame [N, Nm].

        MuJoCo gives what the parent exerts on the link, in and at the site. The environment's is
        the rest of the balance, exact at rest: -(parent's) - (weight of link and children).
        """
        world_from_site = data.site_xmat[self._site].tolist()
        world_from_frame = data.xmat[self._frame].tolist()
        site = data.site_xpos[self._site].tolist()
        to_weight = _minus(data.subtree_com[self._link].tolist(), site)
        to_frame = _minus(site, data.xpos[self._frame].tolist())
        parent_force = _rotate(world_from_site, data.sensordata[self._force].tolist())
        parent_torque = _rotate(world_from_site, data.sensordata[self._torque].tolist())
        force = [-p - w for p, w in zip(parent_force, self._weight, strict=True)]
        parts = (parent_torque, _cross(to_weight, self._weight), _cross(to_frame, force))
        torque = [-p - w + f for p, w, f in zip(*parts, strict=True)]
        force = [f + u for f, u in zip(force, self._unknown, strict=True)]
        return np.array(
            _rotate_back(world_from_frame, force) + _rotate_back(world_from_frame, torque)
        )


class Touch:
    """What of the robot touches the world. Effectors: feet, then hands, left before right."""

    def __init__(self, model: mujoco.MjModel) -> None:
        links = (*talos.SOLE_FRAMES, talos.WRIST_SENSOR_LINK, talos.HAND_FRAMES[1])
        robot = model.body_rootid == model.body(talos.BASE_LINK).id
        effector_of_body = np.where(robot, _BODY, _WORLD)
        for effector, link in enumerate(links):
            effector_of_body[_subtree(model, model.body(link).id)] = effector
        self._effector_of_geom = effector_of_body[model.geom_bodyid]
        self._model = model

    def by_body(self, data: mujoco.MjData) -> bool:
        """Tell whether any part of the robot other than feet and hands touches something."""
        return bool((self._effector_of_geom[data.contact.geom] == _BODY).any())

    def forces(self, data: mujoco.MjData) -> Array:
        """Return what the environment exerts on the end effectors, (4, 3) in the world [N]."""
        total = np.zeros((4, 3))
        wrench = np.zeros(6)
        for index, pair in enumerate(self._effector_of_geom[data.contact.geom]):
            if pair.max() < 0:
                continue
            mujoco.mj_contactForce(self._model, data, index, wrench)
            on_second = data.contact.frame[index].reshape(3, 3).T @ wrench[:3]
            for effector, sign in zip(pair, (-1.0, 1.0), strict=True):
                if effector >= 0:
                    total[effector] += sign * on_second
        return total


def _minus(a: Numbers, b: Numbers) -> Numbers:
    return [a[0] - b[0], a[1] - b[1], a[2] - b[2]]


def _cross(a: Numbers, b: Numbers) -> Numbers:
    """Return a x b."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _rotate(r: Numbers, v: Numbers) -> Numbers:
    """Return R v of a rotation row by row (9,)."""
    x, y, z = v
    return [
        r[0] * x + r[1] * y + r[2] * z,
        r[3] * x + r[4] * y + r[5] * z,
        r[6] * x + r[7] * y + r[8] * z,
    ]


def _rotate_back(r: Numbers, v: Numbers) -> Numbers:
    """Return R' v of a rotation row by row (9,)."""
    x, y, z = v
    return [
        r[0] * x + r[3] * y + r[6] * z,
        r[1] * x + r[4] * y + r[7] * z,
        r[2] * x + r[5] * y + r[8] * z,
    ]


def sensor_slice(model: mujoco.MjModel, name: str) -> slice:
    """Return where a sensor's values are in `MjData.sensordata`."""
    sensor = model.sensor(name)
    start = int(sensor.adr[0])
    return slice(start, start + int(sensor.dim[0]))


def _subtree(model: mujoco.MjModel, body: int) -> list[int]:
    """Return a body and all that hang on it; parents come before children in MuJoCo."""
    members = {body}
    for candidate in range(body + 1, model.nbody):
        if model.body_parentid[candidate] in members:
            members.add(candidate)
    return sorted(members)
