"""What of the simulated robot touches the world, and how hard: truth that no sensor reads."""

import mujoco
import numpy as np

from w2c.messages import Array
from w2c_sim_robot import talos

LOOK_EVERY = 5
"""Ticks: the list of contacts is the dearest thing that a tick reads from MuJoCo."""
_WORLD, _BODY = -1, -2  # beside the indices of the four end effectors


class Touch:
    """What of the robot touches the world. Effectors: feet, then hands, left before right."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        links = (*talos.SOLE_FRAMES, talos.WRIST_SENSOR_LINK, talos.HAND_FRAMES[1])
        robot = model.body_rootid == model.body(talos.BASE_LINK).id
        effector_of_body = np.where(robot, _BODY, _WORLD)
        for effector, link in enumerate(links):
            effector_of_body[_subtree(model, model.body(link).id)] = effector
        self._effector_of_geom = effector_of_body[model.geom_bodyid]
        self._model = model
        self._data = data
        self._contact = data.contact
        self.reset()

    def reset(self) -> None:
        """Forget what touched."""
        self._last_count, self._last_answer = -1, False

    def by_body(self, tick: int) -> bool:
        """Tell whether any part of the robot other than feet and hands touches something.

        Asked at every tick: it looks when the number of contacts changes, and every fifth tick.
        """
        count = self._data.ncon
        if count != self._last_count or tick % LOOK_EVERY == 0:
            self._last_count = count
            geoms = self._effector_of_geom[self._contact.geom]
            self._last_answer = bool((geoms == _BODY).any())
        return self._last_answer

    def forces(self) -> Array:
        """Return what the environment exerts on the end effectors, (4, 3) in the world [N]."""
        total = np.zeros((4, 3))
        wrench = np.zeros(6)
        frames = self._contact.frame
        for index, pair in enumerate(self._effector_of_geom[self._contact.geom].tolist()):
            if max(pair) < 0:
                continue
            mujoco.mj_contactForce(self._model, self._data, index, wrench)
            on_second = frames[index].reshape(3, 3).T @ wrench[:3]
            for effector, sign in zip(pair, (-1.0, 1.0), strict=True):
                if effector >= 0:
                    total[effector] += sign * on_second
        return total


def _subtree(model: mujoco.MjModel, body: int) -> list[int]:
    """Return a body and all that hang on it; parents come before children in MuJoCo."""
    members = {body}
    for candidate in range(body + 1, model.nbody):
        if model.body_parentid[candidate] in members:
            members.add(candidate)
    return sorted(members)
