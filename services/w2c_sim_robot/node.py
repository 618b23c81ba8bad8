"""The simulated Talos as the machine behind a driver: truth beside the state, and pushes."""

import logging
import threading
from pathlib import Path

import mujoco
import numpy as np

from w2c import topics
from w2c.bus import Bus
from w2c.bus.interface import CallContext
from w2c.clock import Clock
from w2c.driver import Driver
from w2c.errors import ConfigError, ControlError
from w2c.messages import Array, PushReply, PushRequest, RobotDescription, RobotState
from w2c.messages.robot import DriverMode
from w2c_sim_robot.config import RobotConfig
from w2c_sim_robot.description import make_description
from w2c_sim_robot.model import build_model
from w2c_sim_robot.perturbation import Perturbation
from w2c_sim_robot.physics import Simulator
from w2c_sim_robot.sensor_errors import combine, typical

_TRUTH_RATE_HZ = 30.0

log = logging.getLogger("w2c.robot")


class SimulatedRobot:
    """See `w2c.driver.Machine`."""

    def __init__(self, config: RobotConfig) -> None:
        """Build it. Raises ConfigError for a bad scene or a robot that is none."""
        # Otherwise MuJoCo writes its warnings to a file in the working directory.
        mujoco.set_mju_user_warning(lambda text: log.warning("mujoco: %s", text))
        self.description = make_description(lock_step=config.lock_step)
        self.simulator = _make_simulator(config, self.description)
        real_time_ticks = round(1e9 / (_TRUTH_RATE_HZ * self.description.period_ns))
        self._truth_every = config.truth_every if config.lock_step else real_time_ticks
        # Between the thread that serves pushes and the loop, which alone touches the simulator.
        self._lock = threading.Lock()

    @property
    def tick(self) -> int:
        """Return the number of steps so far."""
        return self.simulator.tick

    @property
    def command(self) -> Array:
        """Return the joint command in force (n,) [rad]."""
        return self.simulator.command

    def state(self, *, command_tick: int, mode: DriverMode) -> RobotState:
        """Return what the sensors read."""
        return self.simulator.state(command_tick=command_tick, mode=mode)

    def step(self, command: Array, mode: DriverMode) -> None:  # noqa: ARG002 - it holds, that is all
        """Go on by one tick."""
        with self._lock:
            self.simulator.step(command)

    def publish(self, bus: Bus) -> None:
        """Publish the truth, more rarely than the state."""
        if self.simulator.tick % self._truth_every == 0:
            bus.publish(topics.TRUTH, self.simulator.truth())

    def push(self, request: PushRequest, context: CallContext) -> PushReply:
        """Push a body from a tick on.

        Raises:
            ControlError: the caller may not know the truth, so not make it; or it makes no sense.
        """
        if context.caller not in topics.PUSH.callers:
            allowed = ", ".join(topics.PUSH.callers)
            raise ControlError(f"'{context.caller}' may not push the robot, only {allowed} may")
        with self._lock:
            tick = self.simulator.push(
                request.force,
                request.duration_s,
                request.link,
                tick=None if request.tick < 0 else request.tick,
            )
        log.warning("%s pushes %s by %s N", context.caller, request.link, request.force)
        return PushReply(tick=tick)

    def close(self) -> None:
        """Nothing to let go of."""


class RobotNode(Driver):
    """Talos, simulated, on the bus."""

    def __init__(self, config: RobotConfig, bus: Bus, clock: Clock) -> None:
        super().__init__(config, bus, clock, lambda: SimulatedRobot(config))

    @property
    def robot(self) -> SimulatedRobot:
        """Return what is simulated. Raises ConfigError before `configure`."""
        if not isinstance(self.machine, SimulatedRobot):
            raise ConfigError("the machine of this driver is no simulated robot")
        return self.machine

    @property
    def simulator(self) -> Simulator:
        """Return its physics."""
        return self.robot.simulator

    def configure(self) -> None:
        """Build the robot, and answer who asks for it or pushes it."""
        super().configure()
        self._bus.serve(topics.PUSH, self.robot.push)


def _make_simulator(config: RobotConfig, description: RobotDescription) -> Simulator:
    scene = None
    if config.scene:
        from w2c_sim_robot.scenes.scene import load

        scene = load(Path(config.scene))
    perturbation = Perturbation(
        stiffness=config.stiffness_scale,
        friction=config.friction_scale,
        ball_friction=config.ball_friction_scale,
        mass=config.mass_scale,
        hand_mass=config.hand_mass,
        sole_pitch=config.sole_pitch,
        table_height=config.table_height,
    )
    return Simulator(
        build_model(scene, perturbation, visuals=False),
        description,
        sensors=combine(config.sensors, typical(config.noise)),
        generator=np.random.default_rng(config.seed),
        left_hand_mass=perturbation.hand_mass[0],
    )
