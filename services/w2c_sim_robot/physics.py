"""The robot as its driver sees it: commands in, sensor readings out, 2 ms at a time."""

import mujoco
import numpy as np

from w2c.errors import ControlError
from w2c.messages import Array, RobotDescription, RobotState, Truth
from w2c.messages.robot import DriverMode
from w2c_sim_robot import talos
from w2c_sim_robot.model import PHYSICS_STEP_S, ready_configuration
from w2c_sim_robot.sensing import ForceTorqueSensor, Noise, Touch, sensor_slice
from w2c_sim_robot.statics import standing_torque

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
        noise: Noise | None = None,
        seed: int = 0,
        left_hand_mass: float = 0.0,
    ) -> None:
        """Stand ready.

        Args:
            model: the robot and its surroundings.
            description: names the joints and the period.
            noise: of the sensors; None = ideal ones.
            seed: of the noise.
            left_hand_mass: that the model holds in the left hand and the driver does not know of:
                the wrist's sensor reads its weight [kg].
        """
        self._model = model
        self._data = mujoco.MjData(model)
        self._noise = noise or Noise()
        self._noisy = self._noise != Noise()
        self._seed = seed
        self._period_ns = description.period_ns
        self._steps_per_tick = round(description.period_ns * 1e-9 / PHYSICS_STEP_S)
        names = [joint.name for joint in description.joints]
        self._position_index = np.array([model.joint(name).qposadr[0] for name in names])
        self._velocity_index = np.array([model.joint(name).dofadr[0] for name in names])
        self._actuator_index = np.array([model.actuator(name).id for name in names])
        self._base = int(model.joint("base").qposadr[0])
        soles = [
            ForceTorqueSensor(model, f"{side}_sole", frame, frame)
            for side, frame in zip(("left", "right"), talos.SOLE_FRAMES, strict=True)
        ]
        wrist = ForceTorqueSensor(
            model,
            "left_wrist",
            talos.WRIST_SENSOR_LINK,
            talos.HAND_FRAMES[0],
            unknown=left_hand_mass,
        )
        self._wrenches = (*soles, wrist)
        self._orientation = sensor_slice(model, "imu_orientation")
        self._angular_velocity = sensor_slice(model, "imu_angular_velocity")
        self._acceleration = sensor_slice(model, "imu_linear_acceleration")
        self._touch = Touch(model)
        self._effector_bodies = [
            model.body(name).id for name in talos.SOLE_FRAMES + talos.HAND_FRAMES
        ]
        self._ready = ready_configuration(model)
        stiffness = model.actuator_gainprm[self._actuator_index, 0]
        torque = standing_torque(model, self._ready)[self._velocity_index]
        # A spring of this stiffness bears this torque when it is wound up by torque / stiffness.
        self._ready_command = self._ready[self._position_index] + torque / stiffness
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
        """Stand ready at tick 0, in equilibrium."""
        mujoco.mj_resetData(self._model, self._data)
        self._data.qpos[:] = self._ready
        self._data.ctrl[self._actuator_index] = self._ready_command
        self._command: Array = self._ready_command.copy()
        self._tick = 0
        self._push_ticks = 0
        self._fell = False
        mujoco.mj_forward(self._model, self._data)

    def step(self, command: Array) -> None:
        """Advance one tick; the command is approached linearly and reached at its end.

        Args:
            command: joint angles (n,) in the order of the description [rad].

        Raises:
            ControlError: the command has the wrong shape or is not finite, or physics diverged.
        """
        if command.shape != self._command.shape or not np.isfinite(command).all():
            raise ControlError(
                f"command of shape {command.shape}, expected {self._command.shape} finite angles"
            )
        start, way = self._command, command - self._command
        for step in range(1, self._steps_per_tick + 1):
            self._data.ctrl[self._actuator_index] = start + way * (step / self._steps_per_tick)
            mujoco.mj_step(self._model, self._data)
        if not np.isfinite(self._data.qacc).all():
            raise ControlError(f"physics diverged at tick {self._tick}; check scales and scene")
        # A step leaves the frames of its beginning; what is read from now on is where the robot is.
        mujoco.mj_kinematics(self._model, self._data)
        self._command = np.array(command)
        self._tick += 1
        self._end_push()
        self._fell = self._fell or self._has_fallen()

    def push(self, force: Array, duration_s: float, link: str = "torso_2_link") -> None:
        """Push a link at its centre of mass with a force (3,) in the world [N] from now on."""
        self._data.xfrc_applied[:] = 0.0
        self._data.xfrc_applied[self._model.body(link).id, :3] = force
        self._push_ticks = max(1, round(duration_s * 1e9 / self._period_ns))

    def state(self, *, command_tick: int = -1, mode: DriverMode = "holding") -> RobotState:
        """Return what the sensors read. The driver adds what it knows of the command in force."""
        noise, data = self._noise, self._data
        if self._noisy:  # of seed and tick alone: the same tick can be read twice
            self._generator = np.random.default_rng((self._seed, self._tick))
        wrenches = self._read_wrenches()
        w, x, y, z = data.sensordata[self._orientation].tolist()
        return RobotState(
            stamp_ns=self._tick * self._period_ns,
            tick=self._tick,
            position=self._read(data.qpos[self._position_index], noise.position),
            velocity=self._read(data.qvel[self._velocity_index], noise.velocity),
            torque=self._read(data.qfrc_actuator[self._velocity_index], noise.torque),
            sole_wrenches=wrenches[:2],
            left_wrist_wrench=wrenches[2],
            imu_orientation=np.array([x, y, z, w]),
            imu_angular_velocity=self._read(
                data.sensordata[self._angular_velocity], noise.angular_velocity
            ),
            imu_linear_acceleration=self._read(
                data.sensordata[self._acceleration], noise.acceleration
            ),
            command=self._command.copy(),
            command_tick=command_tick,
            mode=mode,
        )

    def truth(self) -> Truth:
        """Return what no sensor reads."""
        data = self._data
        base = data.qpos[self._base : self._base + 7]
        return Truth(
            stamp_ns=self._tick * self._period_ns,
            tick=self._tick,
            generalized_position=np.array(data.qpos),
            world_from_base=np.concatenate([base[:3], np.roll(base[3:], -1)]),
            end_effector_positions=data.xpos[self._effector_bodies],
            contact_forces=self._touch.forces(data),
            fell=self._fell,
            scene=self._movable_objects(),
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

    def _read(self, value: Array, deviation: float) -> Array:
        if deviation == 0.0:
            return np.array(value)
        return np.asarray(value + deviation * self._generator.standard_normal(value.shape))

    def _read_wrenches(self) -> Array:
        """Return the wrenches of the soles and of the left wrist (3, 6)."""
        noise = self._noise
        wrenches = np.array([sensor.read(self._data) for sensor in self._wrenches])
        if self._noisy:
            wrenches[:, :3] = self._read(wrenches[:, :3], noise.force)
            wrenches[:, 3:] = self._read(wrenches[:, 3:], noise.moment)
        return wrenches

    def _movable_objects(self) -> dict[str, tuple[float, float, float]]:
        """Return the positions of what has a free joint and is not the robot."""
        free = self._model.body_dofnum == 6
        free[self._model.body(talos.BASE_LINK).id] = False
        positions = {}
        for body in np.flatnonzero(free):
            x, y, z = (float(value) for value in self._data.xpos[body])
            positions[self._model.body(body).name] = (x, y, z)
        return positions

    def _end_push(self) -> None:
        if self._push_ticks > 0:
            self._push_ticks -= 1
            if self._push_ticks == 0:
                self._data.xfrc_applied[:] = 0.0

    def _has_fallen(self) -> bool:
        low = bool(self._data.qpos[self._base + 2] < LOWEST_BASE_M)
        return low or self._touch.by_body(self._data)
