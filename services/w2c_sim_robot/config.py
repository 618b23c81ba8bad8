"""The flags of `w2c robot`."""

from typing import Annotated

from msgspec import Meta

from w2c.driver.config import DriverConfig
from w2c_sim_robot.sensor_errors import SensorErrors

Scale = Annotated[float, Meta(ge=0.05, le=20.0)]


class RobotConfig(DriverConfig, frozen=True, kw_only=True):
    """The simulated robot and its driver."""

    lock_step: bool = False
    """Wait for the command of each tick instead of keeping real time."""
    scene: str = ""
    """Scene file (JSON) of what stands before the robot; empty = nothing but the floor."""
    seed: int = 0
    """Of the errors of the sensors."""
    truth_every: Annotated[int, Meta(ge=1)] = 10
    """In lock step, publish `truth` every so many ticks; in real time it goes out at 30 Hz."""
    noise: Annotated[float, Meta(ge=0.0, le=100.0)] = 0.0
    """Sensor noise: 0 = none, 1 = of ordinary sensors. What `sensors` says goes before it."""
    sensors: SensorErrors = SensorErrors()
    """How each sensor errs."""
    stiffness_scale: Scale = 1.0
    """True joint stiffness over the described one."""
    friction_scale: Scale = 1.0
    """Of feet and hands; 1 = coefficient 0.8."""
    ball_friction_scale: Scale = 1.0
    """Of the ball-ended right hand alone, beside `friction_scale`."""
    mass_scale: Scale = 1.0
    """True masses over the described ones."""
    hand_mass: tuple[float, float] = (0.0, 0.0)
    """Masses in the hands that nobody is told of, left and right, 0 to 50 [kg]."""
    sole_pitch: tuple[float, float] = (0.0, 0.0)
    """Tilt of the undersides of the feet, left and right, toes down, up to 0.17 [rad]."""
    table_height: float = 0.0
    """How much higher the scene's things truly stand than the camera shows, up to 0.2 [m]."""
