"""A robot that does what the controller means it to, for timing: next to no time of its own."""

import numpy as np
import numpy.typing as npt

from w2c.messages import RobotDescription, RobotState
from w2c_controller.controller import Controller
from w2c_controller.kinematics.model import Kinematics, standing_configuration
from w2c_controller.parameters import FEET, HANDS, LEFT_HAND

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

SURFACE_STIFFNESS = 5000.0
"""[N/m]"""
ANGLE_NOISE = 1e-5
"""[rad]"""
FORCE_NOISE = 0.2
"""[N] and [Nm]"""
NOISE_ROWS = 1009
STANDING_FORCE = 440.0
"""On each sole, before the first tick [N]."""


class MeantRobot:
    """Its joints are where the desired posture has them, and its contacts bear what they shall.

    A free hand that sinks into the surface below it feels a spring.
    """

    def __init__(self, controller: Controller, seed: int) -> None:
        """Stand in the initial posture.

        Args:
            controller: The controller that the states are for.
            seed: Of the noise on all sensors.
        """
        self._controller = controller
        self._description: RobotDescription = controller.description
        self.command = np.array(self._description.initial_position)
        self.surfaces: dict[int, float] = {}
        """Height of the surface below each hand, its radius added [m]"""
        self.tick = 0
        model = controller.model
        self._indices = model.joint_indices
        self._kinematics = Kinematics(model)
        self._wrenches = np.zeros((4, 6))
        self._wrenches[:2, 2] = STANDING_FORCE
        self._frames = np.tile(np.eye(3), (4, 1, 1))
        self._q = standing_configuration(model, self.command[self._indices])
        self._noise = np.random.default_rng(seed).standard_normal((NOISE_ROWS, self.command.size))

    def state(self) -> RobotState:
        """Return the state of this tick."""
        kinematics, noise = self._kinematics, self._noise[self.tick % NOISE_ROWS]
        kinematics.update_statics(self._q, self._wrenches, self._frames, (True, True, True, True))
        position, torque = self.command.copy(), np.zeros_like(self.command)
        position[self._indices] = self._q[7:]
        torque[self._indices] = kinematics.static[6:]
        position += ANGLE_NOISE * noise
        torque += FORCE_NOISE * noise
        wrist = np.zeros(6)
        hand = kinematics.rotations[LEFT_HAND]
        wrist[:3] = hand.T @ (self._frames[LEFT_HAND] @ self._wrenches[LEFT_HAND, :3])
        return RobotState(
            stamp_ns=self._description.period_ns * self.tick,
            tick=self.tick,
            position=position,
            velocity=ANGLE_NOISE * noise,
            torque=torque,
            sole_wrenches=self._wrenches[:2] + FORCE_NOISE * noise[:12].reshape(2, 6),
            left_wrist_wrench=wrist,
            imu_orientation=np.array([0.0, 0.0, 0.0, 1.0]),
            imu_angular_velocity=np.zeros(3),
            imu_linear_acceleration=np.array([0.0, 0.0, 9.81]),
            command=self.command,
            command_tick=self.tick - 1,
            mode="tracking" if self.tick else "holding",
        )

    def follow(self, command: Vector) -> None:
        """Take a command (n,) and move to what the controller meant by it."""
        desired = self._controller.retargeting.state
        self.command = command
        self._q[:] = desired.q
        for k in (*FEET, *HANDS):
            if desired.enabled[k]:
                self._wrenches[k] = desired.wrenches[k]
                self._frames[k] = desired.contact_rotations[k]
            else:
                self._wrenches[k] = 0.0
                self._frames[k] = np.eye(3)
        for k, height in self.surfaces.items():
            depth = height - self._controller.retargeting.kinematics.positions[k, 2]
            if depth > 0.0 and not desired.enabled[k]:
                self._wrenches[k, 2] = SURFACE_STIFFNESS * depth
        self.tick += 1
