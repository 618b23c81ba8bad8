"""Gains, filters and limits of the force feedback.

Values are those published with the SEIKO Controller (Rouxel, Ivaldi and Mouret, RA-L 2024) unless a
remark says otherwise; the experiments behind the others are in
`docs/decisions/0008-force-feedback.md`.
"""

from dataclasses import dataclass, field
from typing import Literal

ForceMode = Literal["full", "no_torque_limit", "off"]


@dataclass(frozen=True)
class FlexibleWeights:
    """Of the costs w |residual|^2 of the Controller QP."""

    foot_wrench: float = 0.1
    """On force [N/s] and torque [Nm/s] alike."""
    hand_force: float = 10.0
    command_rate: float = 1e3
    command_offset: float = 1e2
    """On the offset after one tick [rad]: a leak of 2e-4 1/s."""
    foot_position: float = 2e2
    """Of a free foot."""
    foot_rotation: float = 2e1
    hand_position: float = 2e1
    """Of a free hand."""
    hand_rotation: float = 1e2
    """Of a hand in contact."""
    base_velocity: float = 1e-6


@dataclass(frozen=True)
class AdmittanceGains:
    """How a free end effector gives way: speed = gain (|force| - deadband), at most a limit."""

    force_deadband: float
    """[N]"""
    force_gain: float
    """[m/s/N]"""
    speed: float
    """[m/s]"""
    return_speed: float = 0.02
    """Back to the target once the force is gone [m/s]. Ours: SEIKO's operators steer speeds, and
    have no target to return to."""
    farthest: float = 0.1
    """From the target [m]. Ours."""
    zero_time: float = 1.0
    """Time constant with which a steady reading becomes the zero [s]. Ours."""


@dataclass(frozen=True)
class ForceParameters:
    """All of them."""

    mode: ForceMode = "full"
    """off: the command is the desired posture, without offset and feedback."""
    weights: FlexibleWeights = field(default_factory=FlexibleWeights)
    offset_limit: float = 0.5
    """Of each joint's command from its desired angle [rad]."""
    command_margin: float = 0.8
    """Of the Retargeting's margin, that the command keeps from joint limits. SEIKO's is 1: then a
    joint that the posture has at its limit cannot be wound up to bear a torque."""
    proportional: float = 1.0
    """Kp, wrench rate over wrench error [1/s]. SEIKO's is 0.2."""
    damping: float = 0.005
    """Kd, signed, on the measured wrench rate. The paper's equation (10) subtracts it (here -0.02),
    the published code adds it, with this value."""
    complementary_hz: float = 0.2
    """Below it the wrench estimate is the measured one, above it the model's."""
    fade_in: float = 2.0
    """In which the feedback of a new contact grows to its full gain [s]. SEIKO blends the command
    over this time. A touch is harder than the force that is wanted first: at full gain the hand
    would be taken off again."""
    difference_time: float = 0.05
    """Over which the measured wrench rate is a difference [s]."""
    rate_hz: float = 10.0
    """Low-pass of the measured wrench rate."""
    torque_ratio: float = 0.75
    """Measured torque over effort limit from which a joint's torque limit shrinks; 0.6 in the
    paper's experiments."""
    torque_ratio_release: float = 0.65
    """Ratio below which it grows back."""
    torque_slack: float = 1.0
    """Of a shrinking limit above the torque of the model [Nm]."""
    torque_growth: float = 10.0
    """Of a limit that grows back [Nm/s]."""
    payload_least: float = 0.3
    """A smaller mass on a free hand is none [kg]. Ours, not SEIKO's, as all of the payload."""
    payload_rate: float = 0.1
    """At which a free hand at rest learns its mass [kg/s]."""
    torque_hz: float = 2.0
    """Low-pass of measured torques, for these ratios."""
    hand_admittance: AdmittanceGains = AdmittanceGains(10.0, 0.003, 0.1)
    foot_admittance: AdmittanceGains = AdmittanceGains(50.0, 0.0005, 0.01)
