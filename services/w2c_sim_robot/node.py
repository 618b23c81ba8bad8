"""The robot driver on the bus: state out, commands in, stop always.

Real time: the newest command wins, and what happens without one is the watchdog's affair. Lock
step: the state of tick k goes out, and time stands still until the command that answers k comes.
That state is sent again every second, because a controller that starts later has not seen it: a
controller gives a tick that it has answered before the same answer, without computing.
"""

import logging
import threading
from pathlib import Path

import mujoco
import numpy as np

from w2c import topics
from w2c.bus import Bus, Input
from w2c.bus.interface import CallContext, Queue, Received
from w2c.clock import Clock
from w2c.messages import (
    Array,
    Empty,
    JointCommand,
    RobotDescription,
    StopReply,
    StopRequest,
)
from w2c.realtime import NOT_ASKED, ROBOT_PRIORITY, collector_off, real_time
from w2c_sim_robot.config import RobotConfig
from w2c_sim_robot.description import make_description
from w2c_sim_robot.model import build_model
from w2c_sim_robot.pacing import Pacer
from w2c_sim_robot.perturbation import Perturbation
from w2c_sim_robot.physics import Simulator
from w2c_sim_robot.sensor_errors import typical
from w2c_sim_robot.urdf import joint_limits
from w2c_sim_robot.watchdog import Watchdog

_TRUTH_RATE_HZ = 30.0
_POLL_S = 0.1
_REPEAT_AFTER_POLLS = 10

log = logging.getLogger("w2c.robot")


class RobotNode:
    """Talos, simulated."""

    def __init__(self, config: RobotConfig, bus: Bus, clock: Clock) -> None:
        self._config = config
        self._bus = bus
        self._clock = clock
        # Held for microseconds: by the loop for each command, by the handlers of stop and resume.
        self._lock = threading.Lock()
        self._command_input: tuple[Input, ...] = ()
        self._pacer: Pacer | None = None
        self._granted = NOT_ASKED

    @property
    def detail(self) -> str:
        """What people should know of this process: what the system did not grant."""
        return self._granted.trouble

    def configure(self) -> None:
        """Build the robot, and answer who asks for it."""
        config = self._config
        # Otherwise MuJoCo writes its warnings to a file in the working directory.
        mujoco.set_mju_user_warning(lambda text: log.warning("mujoco: %s", text))
        self._description = make_description(lock_step=config.lock_step)
        self.simulator = _make_simulator(config, self._description)
        period_s = self._description.period_ns * 1e-9
        self.watchdog = Watchdog(
            self.simulator.command,
            _limits(self._description),
            period_s=period_s,
            timeout_ticks=max(1, round(config.watchdog_ms * 1e-3 / period_s)),
        )
        real_time_ticks = round(1.0 / (_TRUTH_RATE_HZ * period_s))
        self._truth_every = config.truth_every if config.lock_step else real_time_ticks
        if config.lock_step:
            self._bus.use_lock_step()
            self._commands = self._bus.queue(topics.JOINT_COMMAND)
        else:
            self._newest_command = self._bus.latest(topics.JOINT_COMMAND)
        self._bus.serve(topics.DESCRIBE, lambda _request, _context: self._description)
        self._bus.serve(topics.ROBOT_STOP, self._stop)
        self._bus.serve(topics.ROBOT_RESUME, self._resume)

    def run(self, stop: threading.Event) -> None:
        """Live until `stop`."""
        with collector_off():
            if self._config.lock_step:
                self._run_in_lock_step(stop, self._commands)
                return
            with real_time(ROBOT_PRIORITY, self._config.real_time) as self._granted:
                if self._granted.trouble:
                    log.warning("the loop may be late: %s", self._granted.trouble)
                self._run_in_real_time(stop)

    def close(self) -> None:
        """Say how well time was kept."""
        if self._pacer is not None:
            lateness = self._pacer.lateness_us()
            log.info("lateness %s", {key: round(value) for key, value in lateness.items()})

    def _run_in_real_time(self, stop: threading.Event) -> None:
        self._pacer = Pacer(self._clock, self._description.period_ns)
        self._publish()
        while not stop.is_set():
            if not self._pacer.wait():
                self._bus.count("late 20 ms")
            received = self._newest_command.take()
            if received is not None:
                self._offer(received)
            self._step()
            self._publish()

    def _run_in_lock_step(self, stop: threading.Event, commands: Queue[JointCommand]) -> None:
        while not stop.is_set():
            self._publish()
            if self._wait_for_answer(stop, commands):
                self._step()

    def _wait_for_answer(self, stop: threading.Event, commands: Queue[JointCommand]) -> bool:
        """Return True when this tick was answered, well or badly; False to publish it again."""
        tick = self.simulator.tick
        for _ in range(_REPEAT_AFTER_POLLS):
            received = commands.receive(_POLL_S)
            while received is not None:
                if received.message.tick == tick:
                    self._offer(received)
                    return True
                self._bus.count("command of another tick")
                received = commands.receive(0.0)
            if stop.is_set():
                break
        return False

    def _offer(self, received: Received[JointCommand]) -> None:
        message = received.message
        with self._lock:
            refusal = self.watchdog.offer(
                message.position, answered_tick=message.tick, now_tick=self.simulator.tick
            )
        if refusal is None:
            self._command_input = (received.as_input(),)
        else:
            self._bus.count(f"command refused: {refusal}")

    def _step(self) -> None:
        with self._lock:
            self.watchdog.check(self.simulator.tick)
            command = self.watchdog.command
        self.simulator.step(command)

    def _publish(self) -> None:
        with self._lock:
            mode, command_tick = self.watchdog.mode, self.watchdog.command_tick
        state = self.simulator.state(command_tick=command_tick, mode=mode)
        self._bus.publish(topics.ROBOT_STATE, state, self._command_input)
        if self.simulator.tick % self._truth_every == 0:
            self._bus.publish(topics.TRUTH, self.simulator.truth())

    def _stop(self, request: StopRequest, context: CallContext) -> StopReply:
        with self._lock:
            self.watchdog.stop()
        log.warning("stopped by %s: %s", context.caller, request.reason or "no reason given")
        return self._mode_reply()

    def _resume(self, _request: Empty, context: CallContext) -> StopReply:
        with self._lock:
            self.watchdog.resume()
        log.warning("resumed by %s", context.caller)
        return self._mode_reply()

    def _mode_reply(self) -> StopReply:
        return StopReply(
            mode=self.watchdog.mode, stamp_ns=self.simulator.tick * self._description.period_ns
        )


def _make_simulator(config: RobotConfig, description: RobotDescription) -> Simulator:
    scene = None
    if config.scene:
        from w2c_sim_robot.scenes.scene import load

        scene = load(Path(config.scene))
    perturbation = Perturbation(
        stiffness=config.stiffness_scale, friction=config.friction_scale, mass=config.mass_scale
    )
    return Simulator(
        build_model(scene, perturbation, visuals=False),
        description,
        sensors=typical(config.noise),
        generator=np.random.default_rng(config.seed),
    )


def _limits(description: RobotDescription) -> Array:
    """Return lower and upper limits of the joints of the description (n, 2) [rad]."""
    limits = joint_limits(description.urdf)
    return np.array([limits[joint.name] for joint in description.joints])
