"""How the simulated sensors may err, as configuration; `imperfection` makes them do so."""

from typing import Annotated

import msgspec

from w2c.errors import ConfigError

Deviation = Annotated[float, msgspec.Meta(ge=0.0, le=1e6)]
Delay = Annotated[float, msgspec.Meta(ge=0.0, le=1000.0)]
Share = Annotated[float, msgspec.Meta(ge=0.0, le=0.99)]


class JointErrors(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Of the sensors of one kind in all joints. Units: [rad], [rad/s] or [Nm], as what it reads."""

    noise: Deviation = 0.0
    """Standard deviation of what is added to each value, anew at each tick."""
    bias: Deviation = 0.0
    """Each joint has a constant error of at most this, drawn evenly at the start."""
    delay_ms: Delay = 0.0
    """How old what is read is [ms]; the state's stamp does not tell."""
    dropout: Share = 0.0
    """Probability that a tick's values do not arrive: the last ones are read again."""


class ForceTorqueErrors(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Of force-torque sensors. Each one loses its readings for itself."""

    force_noise: Deviation = 0.0
    """Standard deviation [N]."""
    moment_noise: Deviation = 0.0
    """Standard deviation [Nm]."""
    force_bias: Deviation = 0.0
    """Each axis has a constant error of at most this [N]."""
    moment_bias: Deviation = 0.0
    """Each axis has a constant error of at most this [Nm]."""
    delay_ms: Delay = 0.0
    """How old what is read is [ms]."""
    dropout: Share = 0.0
    """Probability that a tick's wrench does not arrive: the last one is read again."""


class ImuErrors(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Of the inertial measurement unit."""

    orientation_noise: Deviation = 0.0
    """Standard deviation of a turn about each axis of the IMU [rad]."""
    orientation_bias: Deviation = 0.0
    """It is mounted askew by at most this about each axis [rad]."""
    angular_velocity_noise: Deviation = 0.0
    """Standard deviation [rad/s]."""
    angular_velocity_bias: Deviation = 0.0
    """Each axis has a constant error of at most this [rad/s]."""
    acceleration_noise: Deviation = 0.0
    """Standard deviation [m/s^2]."""
    acceleration_bias: Deviation = 0.0
    """Each axis has a constant error of at most this [m/s^2]."""
    delay_ms: Delay = 0.0
    """How old what is read is [ms]."""
    dropout: Share = 0.0
    """Probability that a tick's values do not arrive: the last ones are read again."""


class SensorErrors(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Of all sensors of the robot; all zero = ideal ones."""

    position: JointErrors = JointErrors()
    """Joint encoders [rad]."""
    velocity: JointErrors = JointErrors()
    """Joint velocities [rad/s]."""
    torque: JointErrors = JointErrors()
    """Joint torques [Nm]."""
    soles: ForceTorqueErrors = ForceTorqueErrors()
    """Under both feet."""
    wrist: ForceTorqueErrors = ForceTorqueErrors()
    """Of the left hand."""
    imu: ImuErrors = ImuErrors()
    """In the pelvis."""


def typical(scale: float = 1.0) -> SensorErrors:
    """Return the noise of ordinary sensors times `scale`. Raises ConfigError beyond 0 to 100."""
    if not 0.0 <= scale <= 100.0:
        raise ConfigError(f"noise scale {scale:g} is outside 0 to 100; 1 is ordinary sensors")
    force_torque = ForceTorqueErrors(force_noise=1.0 * scale, moment_noise=0.05 * scale)
    return SensorErrors(
        position=JointErrors(noise=2e-5 * scale),
        velocity=JointErrors(noise=5e-3 * scale),
        torque=JointErrors(noise=0.5 * scale),
        soles=force_torque,
        wrist=force_torque,
        imu=ImuErrors(angular_velocity_noise=2e-3 * scale, acceleration_noise=2e-2 * scale),
    )


def combine(first: SensorErrors, second: SensorErrors) -> SensorErrors:
    """Return the errors of the first, and those of the second where the first has none."""
    sensors = {}
    for sensor in SensorErrors.__struct_fields__:
        ours, theirs = getattr(first, sensor), getattr(second, sensor)
        fields = {
            name: getattr(ours, name) or getattr(theirs, name) for name in ours.__struct_fields__
        }
        sensors[sensor] = type(ours)(**fields)
    return SensorErrors(**sensors)
