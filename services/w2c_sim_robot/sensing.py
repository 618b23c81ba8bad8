"""What ideal sensors of the simulated robot read, from MuJoCo's state.

Read 500 times a second: one gathering of all that is needed, and plain numbers where vectors are
three long, because numpy's overhead would be four times the arithmetic.
"""

from collections.abc import Iterable, Sequence

import mujoco
import numpy as np

from w2c.messages import Array
from w2c_sim_robot import talos

WRENCH_FRAMES = (*talos.SOLE_FRAMES, talos.HAND_FRAMES[0])
_LINKS = (*talos.SOLE_FRAMES, talos.WRIST_SENSOR_LINK)
_NAMES = ("left_sole", "right_sole", "left_wrist")


class Channels:
    """Where each sensor's values are in the vector of all readings."""

    def __init__(self, joints: int) -> None:
        n = joints
        self.position = slice(0, n)
        self.velocity = slice(n, 2 * n)
        self.torque = slice(2 * n, 3 * n)
        self.orientation = slice(3 * n, 3 * n + 4)
        """xyzw"""
        self.angular_velocity = slice(3 * n + 4, 3 * n + 7)
        self.acceleration = slice(3 * n + 7, 3 * n + 10)
        self.wrenches = slice(3 * n + 10, 3 * n + 28)
        """Left sole, right sole, left wrist: force, then torque"""
        self.width = 3 * n + 28


class IdealSensors:
    """Reads every sensor of the robot into one vector; see `Channels`."""

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        channels: Channels,
        joints: Sequence[str],
        *,
        left_hand_mass: float = 0.0,
    ) -> None:
        """Look everything up.

        Args:
            model: the robot and its surroundings.
            data: what is read.
            channels: of as many joints as there are names.
            joints: names, in the order of all joint vectors.
            left_hand_mass: in the hand, which the wrist's sensor is not told of [kg].
        """
        unknown = (0.0, 0.0, left_hand_mass)
        self._left, self._right, self._wrist = (
            ForceTorqueSensor(model, name, link, frame, unknown=mass)
            for name, link, frame, mass in zip(_NAMES, _LINKS, WRENCH_FRAMES, unknown, strict=True)
        )
        positions = [int(model.joint(name).qposadr[0]) for name in joints]
        velocities = [int(model.joint(name).dofadr[0]) for name in joints]
        w, x, y, z = sensor_range(model, "imu_orientation")
        imu = [
            *(x, y, z, w),
            *sensor_range(model, "imu_angular_velocity"),
            *sensor_range(model, "imu_linear_acceleration"),
        ]
        places: list[tuple[Array, Sequence[int]]] = [
            (data.qpos, positions),
            (data.qvel, velocities),
            (data.qfrc_actuator, velocities),
            (data.sensordata, imu),
        ]
        for sensor in (self._left, self._right, self._wrist):
            places += sensor.places(data)
        self._gather = Gather(data, places)
        self._wrenches = channels.wrenches
        self._width = channels.width

    def read(self) -> Array:
        """Return what they read (width,), a new vector."""
        gathered = self._gather.read()
        numbers = gathered[self._wrenches.start :].tolist()
        reading = gathered[: self._width].copy()
        n = FORCE_TORQUE_NUMBERS
        reading[self._wrenches] = (
            self._left.wrench(numbers[:n])
            + self._right.wrench(numbers[n : 2 * n])
            + self._wrist.wrench(numbers[2 * n :])
        )
        return reading


class Gather:
    """Reads numbers from many places of MjData at once.

    All its arrays of fixed size lie in one piece of memory: a view of all of it makes one gathering
    of what would be a dozen. They stay where they are as long as the data lives.
    """

    def __init__(self, data: mujoco.MjData, places: Iterable[tuple[Array, Sequence[int]]]) -> None:
        """Take arrays of some data, each with the indices of what is wanted of it when flat."""
        self._data = data  # its arrays do not keep it alive
        places = list(places)
        begin = min(_address(array) for array, _ in places)
        end = max(_address(array) + array.nbytes for array, _ in places)
        lowest = next(array for array, _ in places if _address(array) == begin)
        itemsize = lowest.itemsize
        self._memory = np.lib.stride_tricks.as_strided(
            lowest.reshape(-1), ((end - begin) // itemsize,), (itemsize,), writeable=False
        )
        self._index = np.concatenate(
            [(_address(array) - begin) // itemsize + np.array(wanted) for array, wanted in places]
        )
        self._out = np.zeros(len(self._index))

    def read(self) -> Array:
        """Return the numbers; the next reading overwrites them."""
        self._memory.take(self._index, out=self._out, mode="clip")
        return self._out


FORCE_TORQUE_NUMBERS = 33
"""What a force-torque sensor needs of MjData; see `ForceTorqueSensor.places`."""


class ForceTorqueSensor:
    """Between a link and its parent: what the environment exerts on all that hangs on the link."""

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
        self._link, self._site = model.body(link).id, model.site(name).id
        self._frame = model.body(frame).id
        self._force = sensor_range(model, f"{name}_force")
        self._torque = sensor_range(model, f"{name}_torque")
        weight = model.body_subtreemass[self._link] * model.opt.gravity
        self._weight = tuple(weight.tolist())
        """In the world (3,) [N]"""
        self._unknown = tuple((unknown * model.opt.gravity).tolist())

    def places(self, data: mujoco.MjData) -> list[tuple[Array, Sequence[int]]]:
        """Return what `wrench` wants, in its order."""
        site, frame, link = self._site, self._frame, self._link
        return [
            (data.site_xmat, range(9 * site, 9 * site + 9)),
            (data.xmat, range(9 * frame, 9 * frame + 9)),
            (data.site_xpos, range(3 * site, 3 * site + 3)),
            (data.xpos, range(3 * frame, 3 * frame + 3)),
            (data.subtree_com, range(3 * link, 3 * link + 3)),
            (data.sensordata, self._force),
            (data.sensordata, self._torque),
        ]

    def wrench(self, numbers: Sequence[float]) -> tuple[float, ...]:
        """Return the wrench (6,), force then torque, in and at the frame [N, Nm].

        MuJoCo gives what the parent exerts on the link, in and at the site. The environment's is
        the rest of the balance, exact at rest: -(parent's) - (weight of link and children).

        Args:
            numbers: world_from_site and world_from_frame row by row, where the site, the frame and
                the centre of mass of what hangs on the link are, the parent's force and torque.
        """
        sxx, sxy, sxz, syx, syy, syz, szx, szy, szz = numbers[:9]
        fxx, fxy, fxz, fyx, fyy, fyz, fzx, fzy, fzz = numbers[9:18]
        site_x, site_y, site_z, frame_x, frame_y, frame_z, com_x, com_y, com_z = numbers[18:27]
        px, py, pz, qx, qy, qz = numbers[27:]
        weight_x, weight_y, weight_z = self._weight
        force_x = -(sxx * px + sxy * py + sxz * pz) - weight_x
        force_y = -(syx * px + syy * py + syz * pz) - weight_y
        force_z = -(szx * px + szy * py + szz * pz) - weight_z
        # About the frame's origin: -(parent's) - (com - site) x weight + (site - frame) x force.
        ax, ay, az = com_x - site_x, com_y - site_y, com_z - site_z
        bx, by, bz = site_x - frame_x, site_y - frame_y, site_z - frame_z
        torque_x = -(sxx * qx + sxy * qy + sxz * qz) - (ay * weight_z - az * weight_y)
        torque_y = -(syx * qx + syy * qy + syz * qz) - (az * weight_x - ax * weight_z)
        torque_z = -(szx * qx + szy * qy + szz * qz) - (ax * weight_y - ay * weight_x)
        torque_x += by * force_z - bz * force_y
        torque_y += bz * force_x - bx * force_z
        torque_z += bx * force_y - by * force_x
        unknown_x, unknown_y, unknown_z = self._unknown
        force_x, force_y, force_z = force_x + unknown_x, force_y + unknown_y, force_z + unknown_z
        return (
            fxx * force_x + fyx * force_y + fzx * force_z,
            fxy * force_x + fyy * force_y + fzy * force_z,
            fxz * force_x + fyz * force_y + fzz * force_z,
            fxx * torque_x + fyx * torque_y + fzx * torque_z,
            fxy * torque_x + fyy * torque_y + fzy * torque_z,
            fxz * torque_x + fyz * torque_y + fzz * torque_z,
        )


def sensor_range(model: mujoco.MjModel, name: str) -> range:
    """Return the indices of a sensor's values in `MjData.sensordata`."""
    sensor = model.sensor(name)
    start = int(sensor.adr[0])
    return range(start, start + int(sensor.dim[0]))


def _address(array: Array) -> int:
    return int(array.__array_interface__["data"][0])
