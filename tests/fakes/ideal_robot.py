"""A robot whose joints are where they are commanded to be."""

import numpy as np
import pinocchio as pin

from w2c.messages import Array, JointCommand, RobotDescription, RobotState
from w2c.messages.robot import DriverMode
from w2c_controller.controller import Controller
from w2c_controller.kinematics.model import Kinematics, build_model, standing_configuration


class IdealRobot:
    """Joints that are where they are commanded to be, and feel the weight of the arms."""

    def __init__(self, description: RobotDescription) -> None:
        self.command = np.array(description.initial_position)
        self.torque = np.zeros_like(self.command)
        self._model = build_model(description)
        self._kinematics = Kinematics(self._model)
        self._data = self._model.model.createData()
        self.lean(np.zeros(3))
        self.tick = 0
        self.mode: DriverMode = "holding"
        self.position: Array | None = None

    def lean(self, force: Array) -> None:
        """Let the right hand feel a force (3,) in the world from now on [N]."""
        self._force = force
        model, kinematics, data = self._model, self._kinematics, self._data
        q = standing_configuration(model, self.command[model.joint_indices], data)
        kinematics.update_frames(q)
        torque = pin.computeGeneralizedGravity(model.model, data, q)
        torque = torque - kinematics.jacobians[3, :3].T @ force
        self.torque[model.joint_indices] = torque[6:]

    def state(self) -> RobotState:
        self.lean(self._force)
        n = self.command.shape[0]
        return RobotState(
            stamp_ns=10_000_000 * self.tick,
            tick=self.tick,
            position=(self.command if self.position is None else self.position).copy(),
            velocity=np.zeros(n),
            torque=self.torque.copy(),
            sole_wrenches=np.tile([0.0, 0.0, 440.0, 0.0, 0.0, 0.0], (2, 1)),
            left_wrist_wrench=np.zeros(6),
            imu_orientation=np.array([0.0, 0.0, 0.0, 1.0]),
            imu_angular_velocity=np.zeros(3),
            imu_linear_acceleration=np.array([0.0, 0.0, 9.81]),
            command=self.command.copy(),
            command_tick=self.tick - 1,
            mode=self.mode,
        )

    def step(self, controller: Controller, ticks: int = 1) -> JointCommand:
        for _ in range(ticks):
            answer = controller.tick(self.state())
            if self.mode != "stopped":
                self.command = answer.position
                self.mode = "tracking"
            self.tick += 1
        return answer
