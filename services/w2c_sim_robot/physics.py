"""The robot as its driver sees it: commands in, sensor readings out, 2 ms at a time."""

import mujoco
import numpy as np

from w2c.errors import ConfigError, ControlError
from w2c.messages import Array, RobotDescription, RobotState, Truth
from w2c.messages.base import all_finite
from w2c.messages.robot import DriverMode
from w2c_sim_robot import talos
from w2c_sim_robot.imperfection import Imperfection
from w2c_sim_robot.model import PHYSICS_STEP_S, ready_configuration
from w2c_sim_robot.pushes import Pushes
from w2c_sim_robot.sensing import Channels, IdealSensors
from w2c_sim_robot.sensor_errors import SensorErrors
from w2c_sim_robot.statics import standing_torque
from w2c_sim_robot.touch import Touch

LOWEST_BASE_M = 0.65
"""A pelvis below this has fallen; it stands at 1.02 m, and knees bent to their limit give 0.7 m."""


class Simulator:
    """Talos in MuJoCo. Deterministic: the same commands and pushes give the same bits.

    Forces, torques and accelerations are read at the last 1 ms step, joint angles after it.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        description: RobotDescription,
        *,
        sensors: SensorErrors | None = None,
        generator: np.random.Generator | None = None,
        left_hand_mass: float = 0.0,
    ) -> None:
        """Stand ready.

        Args:
            model: the robot and its surroundings.
            description: names the joints and the period.
            sensors: how they err; None = not at all.
            generator: seeded, and for this robot alone: its sensors' errors come from it.
            left_hand_mass: that the model holds in the left hand and the driver does not know of:
                the wrist's sensor reads its weight [kg].

        Raises:
            ConfigError: sensors that err have no generator; the model has other actuators.
        """
        self._model = model
        self._data = data = mujoco.MjData(model)
        self._period_ns = description.period_ns
        steps = round(description.period_ns * 1e-9 / PHYSICS_STEP_S)
        self._shares = [step / steps for step in range(1, steps + 1)]
        """Of the way to a command, step by step"""
        names = [joint.name for joint in description.joints]
        position = np.array([int(model.joint(name).qposadr[0]) for name in names])
        velocity = np.array([int(model.joint(name).dofadr[0]) for name in names])
        actuators = [int(model.actuator(name).id) for name in names]
        if actuators != list(range(model.nu)):
            raise ConfigError("the model's actuators are not the described joints, in their order")
        self._base = int(model.joint("base").qposadr[0])
        # Each look-up of an array in MjData costs as much as a sum of it.
        self._qpos, self._ctrl = data.qpos, data.ctrl
        self._divergence = data.warning[int(mujoco.mjtWarning.mjWARN_BADQACC)]
        self._channels = Channels(len(names))
        self._ideal = IdealSensors(
            model, data, self._channels, names, left_hand_mass=left_hand_mass
        )
        self._imperfection = _imperfection(sensors, generator, self._channels, description)
        self._touch = Touch(model, data)
        self._pushes = Pushes(model, data, description.period_ns)
        self._effector_bodies = [
            model.body(name).id for name in talos.SOLE_FRAMES + talos.HAND_FRAMES
        ]
        self._movable = _movable_bodies(model)
        self._ready = ready_configuration(model)
        stiffness = model.actuator_gainprm[:, 0]
        torque = standing_torque(model, self._ready)[velocity]
        # A spring of this stiffness bears this torque when it is wound up by torque / stiffness.
        self._ready_command = self._ready[position] + torque / stiffness
        self.reset()

    @property
    def model(self) -> mujoco.MjModel:
        """Return the MuJoCo model."""
        return self._model

    @property
    def tick(self) -> int:
        """Return the number of ticks since the last reset."""
        return self._tick

    @property
    def command(self) -> Array:
        """Return the command in force (n,) [rad]."""
        return self._command.copy()

    @property
    def fell(self) -> bool:
        """Return whether the robot has fallen since the last reset."""
        return self._fell

    def reset(self) -> None:
        """Stand ready at tick 0, in equilibrium; the sensors' errors begin anew."""
        mujoco.mj_resetData(self._model, self._data)
        self._qpos[:] = self._ready
        self._ctrl[:] = self._ready_command
        self._command: Array = self._ready_command.copy()
        self._tick = 0
        self._pushes.reset()
        self._touch.reset()
        self._fell = False
        mujoco.mj_forward(self._model, self._data)
        if self._imperfection is not None:
            self._imperfection.reset()
            self._reading = self._imperfection.read(self._ideal.read())

    def step(self, command: Array) -> None:
        """Advance one tick; the command is approached linearly and reached at its end.

        Args:
            command: joint angles (n,) in the order of the description [rad].

        Raises:
            ControlError: the command has the wrong shape or is not finite, or physics diverged.
        """
        if command.shape != self._command.shape or not all_finite(command):
            raise ControlError(
                f"command of shape {command.shape}, expected {self._command.shape} finite angles"
            )
        self._pushes.begin(self._tick)
        start, way = self._command, command - self._command
        for share in self._shares:
            np.add(start, way * share, out=self._ctrl)
            mujoco.mj_step(self._model, self._data)
        if self._divergence.number:  # an acceleration that is NaN or beyond 1e10
            raise ControlError(f"physics diverged at tick {self._tick}; check scales and scene")
        # A step leaves the frames of its beginning; what is read from now on is where the robot is.
        mujoco.mj_kinematics(self._model, self._data)
        self._command = command.copy()
        self._tick += 1
        self._pushes.end(self._tick)
        self._fell = self._fell or self._has_fallen()
        if self._imperfection is not None:
            self._reading = self._imperfection.read(self._ideal.read())

    def push(
        self,
        force: Array,
        duration_s: float,
        link: str = "torso_2_link",
        *,
        tick: int | None = None,
    ) -> int:
        """Push a body at its centre of mass. Pushes add up.

        Args:
            force: (3,) in the world [N].
            duration_s: at least a tick [s].
            link: any body of the model: a link of the robot, an object of the scene.
            tick: when it begins; None = now.

        Returns:
            The tick at which it begins.

        Raises:
            ControlError: no such body, a tick that is past, a force or a time beyond its limits.
        """
        return self._pushes.add(force, duration_s, link, now=self._tick, tick=tick)

    def state(self, *, command_tick: int = -1, mode: DriverMode = "holding") -> RobotState:
        """Return what the sensors read. The driver adds what it knows of the command in force.

        The state of a tick can be read again and again: it stays the same.
        """
        values = self._ideal.read() if self._imperfection is None else self._reading.copy()
        channels = self._channels
        wrenches = values[channels.wrenches].reshape(3, 6)
        return RobotState(
            stamp_ns=self._tick * self._period_ns,
            tick=self._tick,
            position=values[channels.position],
            velocity=values[channels.velocity],
            torque=values[channels.torque],
            sole_wrenches=wrenches[:2],
            left_wrist_wrench=wrenches[2],
            imu_orientation=values[channels.orientation],
            imu_angular_velocity=values[channels.angular_velocity],
            imu_linear_acceleration=values[channels.acceleration],
            command=self._command.copy(),
            command_tick=command_tick,
            mode=mode,
        )

    def truth(self) -> Truth:
        """Return what no sensor reads."""
        data = self._data
        base = self._qpos[self._base : self._base + 7].tolist()
        positions = data.xpos
        return Truth(
            stamp_ns=self._tick * self._period_ns,
            tick=self._tick,
            generalized_position=self._qpos.copy(),
            world_from_base=np.array([*base[:3], *base[4:], base[3]]),
            end_effector_positions=positions[self._effector_bodies],
            contact_forces=self._touch.forces(),
            fell=self._fell,
            scene={name: tuple(positions[body].tolist()) for name, body in self._movable},
        )

    def point_velocity(self, effector: int, offset: Array) -> Array:
        """Return how fast a point of an end effector moves (3,) in the world [m/s].

        Args:
            effector: index, feet first.
            offset: (3,) of the point from the origin of the end effector, in the world [m].
        """
        twist, body = np.zeros(6), self._effector_bodies[effector]
        mujoco.mj_objectVelocity(self._model, self._data, mujoco.mjtObj.mjOBJ_XBODY, body, twist, 0)
        return twist[3:] + np.cross(twist[:3], offset)

    def _has_fallen(self) -> bool:
        return self._qpos.item(self._base + 2) < LOWEST_BASE_M or self._touch.by_body(self._tick)


def _imperfection(
    sensors: SensorErrors | None,
    generator: np.random.Generator | None,
    channels: Channels,
    description: RobotDescription,
) -> Imperfection | None:
    """Return what makes the sensors err; None where they do not."""
    if sensors is None or sensors == SensorErrors():
        return None
    if generator is None:
        raise ConfigError("sensors that err need a generator: numpy.random.default_rng(seed)")
    return Imperfection(sensors, channels, generator, period_s=description.period_ns * 1e-9)


def _movable_bodies(model: mujoco.MjModel) -> list[tuple[str, int]]:
    """Return name and index of what has a free joint and is not the robot."""
    free = model.body_dofnum == 6
    free[model.body(talos.BASE_LINK).id] = False
    return [(model.body(body).name, int(body)) for body in np.flatnonzero(free)]
