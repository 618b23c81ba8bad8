"""Every number of the controller: weights, limits and rates, with units and where they come from.

Values without a remark are those published for Talos with SEIKO (arXiv 2312.16465 and its parameter
tables). `dataclasses.replace` makes variants; nothing here changes at run time.
"""

from dataclasses import dataclass, field
from typing import Final

from w2c_controller.seiko.force_parameters import ForceParameters
from w2c_controller.switching.contact_parameters import Push, Supervision

LEFT_FOOT: Final = 0
RIGHT_FOOT: Final = 1
LEFT_HAND: Final = 2
RIGHT_HAND: Final = 3
EFFECTORS: Final = ("left_foot", "right_foot", "left_hand", "right_hand")
"""Order of every array over end effectors. Feet are plane contacts, hands point contacts."""
FEET: Final = (LEFT_FOOT, RIGHT_FOOT)
HANDS: Final = (LEFT_HAND, RIGHT_HAND)

DEGREE: Final = 0.017453292519943295


@dataclass(frozen=True)
class Weights:
    """Of the costs w |residual|^2."""

    joint_velocity: float = 1000.0
    posture: float = 10.0
    momentum: float = 1e-6
    """Centroidal. It changes wrench rates by less than 1e-5 N/s, and keeps H positive definite
    where no end effector is free."""
    foot_position: float = 1e5
    foot_rotation: float = 1e4
    hand_position: float = 5e4
    """SEIKO's is 5e3. With that, posture and torque costs hold a far reach 1 cm off its point
    long before balance does, and the window that a support opens shrinks from 18 to 7 cm."""
    hand_rotation: tuple[float, float] = (2e3, 0.0)
    """Left, right. SEIKO's is 100 for both. Fingers keep their direction within 5 degrees with
    this; the orientation of a ball means nothing."""
    arm_torque: float = 0.005
    body_torque: float = 2e-5
    plane_wrench: tuple[float, ...] = (0.002, 0.002, 2e-5, 0.002, 0.002, 0.002)
    """Force x, y, z, torque x, y, z in the sole frame; the normal is cheap, so it shares the
    weight."""
    point_force: tuple[float, float, float] = (0.005, 0.005, 5e-5)
    """In the contact frame."""
    release_factor: float = 1e4
    """On the normalised wrench weights of a contact that is being unloaded."""
    push: float = 1e4
    """On all components of the wrench of a contact in push mode."""


@dataclass(frozen=True)
class Limits:
    """What a solution may not exceed."""

    joint_margin: float = 15 * DEGREE
    """Kept from the limits of the URDF [rad]."""
    joint_margin_factors: dict[str, float] = field(default_factory=lambda: {"torso_2_joint": 0.7})
    velocity_fraction: float = 0.2
    """Of the URDF's velocity limit."""
    balance_velocity_fraction: float = 0.07
    """The same for legs and trunk. Ours: on the way back from the end of a reach a desired trunk
    that may swing at 1 rad/s topples the robot, though each posture on its way is stable."""
    torque_fraction: float = 0.65
    """Of the effort limit."""
    friction: float = 0.6
    cop_x: float = 0.04
    """Half length of the area where the centre of pressure may be [m]; the sole's is 0.10."""
    cop_y: float = 0.03
    foot_force_min: float = 100.0
    foot_force_max: float = 1000.0
    hand_force_min: float = 10.0
    hand_force_max: float = 150.0
    foot_force_rate: float = 60.0
    """[N/s]"""
    foot_torque_rate: float = 2.4
    """[Nm/s]"""
    hand_force_rate: float = 10.0
    lost_force_rate: float = 1000.0
    """Of all contacts while one is unloaded that carries nothing any more [N/s]. Ours."""
    lost_torque_rate: float = 200.0
    """Of the feet meanwhile [Nm/s]. Ours."""


@dataclass(frozen=True)
class Clamps:
    """The largest error that one tick tries to remove."""

    posture: float = 10 * DEGREE
    position: float = 0.04
    """[m]"""
    rotation: float = 10 * DEGREE
    # The equalities ask to remove the whole drift in one tick. Unbounded, a drift of 0.3 N or 0.1
    # mm
    # makes the QP infeasible against its rate limits; bounded, 30 N are absorbed within seconds.
    bias_force: float = 0.05
    """Correction of the static equilibrium in one tick [N]."""
    bias_torque: float = 0.002
    """[Nm]"""
    bias_position: float = 20e-6
    """Correction of a contact's position in one tick [m]."""
    bias_rotation: float = 1e-4
    """[rad]"""


@dataclass(frozen=True)
class Filters:
    """Command pre-processing of a free hand."""

    low_pass_hz: float = 2.0
    lead_position: float = 0.03
    """How far the commanded point may run ahead of the hand [m]: anti-windup."""
    lead_rotation: float = 0.2
    speed: float = 0.2
    """[m/s]"""
    acceleration: float = 2.0
    angular_speed: float = 1.0
    angular_acceleration: float = 3.0


@dataclass(frozen=True)
class Motion:
    """Of the way to a target, and how a contact is made and released. Ours, not SEIKO's."""

    via_height: float = 0.06
    """Of the point above the surface from which the hand comes down along the normal [m]."""
    speed: float = 0.18
    """Of free motion [m/s]."""
    reach_speed: float = 0.08
    """On the last centimetres of a reach [m/s]."""
    touch_speed: float = 0.025
    """Along the normal, near the surface [m/s]."""
    foot_speed: float = 0.1
    """Of a foot in the air [m/s]."""
    foot_lift: float = 0.05
    """How high a released foot is held, and from where one comes down [m]."""
    foot_touch_force: float = 30.0
    """Measured normal force that is a touch of a foot [N]."""
    foot_load_confirmed: float = 60.0
    """Measured normal force without which a foot does not count as loaded [N]."""
    same_contact: float = 0.02
    """A goal this close to where its hand leans already is the same contact [m]."""
    overtravel: float = 0.03
    """How far below the expected surface it is searched before giving up [m]."""
    touch_force: float = 10.0
    """Measured normal force that is a touch [N]."""
    load_confirmed: float = 5.0
    """Measured normal force without which a contact does not count as loaded [N]."""
    reached_distance: float = 0.02
    """From where a reaching hand shall stop, off the surface [m]."""
    reached_speed: float = 0.02
    bump_force: float = 10.0
    """Measured force that stops a reaching hand [N]."""
    air_bump_force: float = 35.0
    """The same on the way, where an arm that swings reads up to 15 N of its own in its joints when
    ticks come late [N]"""
    air_bump_time: float = 0.12
    """For which it must be felt [s]: an arm whose command stood still for a while and then goes on
    is jerked, and swings back within a tenth of a second"""
    air_bump_hard: float = 3.0
    """So many times that force stops sooner"""
    air_bump_hard_time: float = 0.012
    """For which that must be felt [s], so twice: where commands were lost the next one is a leap of
    a few milliradians, which reads once as 130 N"""
    foot_bump_force: float = 40.0
    bump_retreat: float = 0.002
    """How far it then backs off along the normal [m]."""
    bump_distance: float = 0.03
    """A hand stopped this close to its point has reached it [m]."""
    stall_distance: float = 0.002
    """Less progress than this within `stall_time` is a stall [m]."""
    stall_time: float = 2.0
    approach_timeout: float = 30.0
    """Wall of robot time for one phase [s]."""
    load_timeout: float = 15.0
    unload_timeout: float = 30.0
    ramp_stall_force: float = 1.0
    """A ramp that changes less than this within `ramp_stall_time` does not go on [N]."""
    ramp_stall_time: float = 4.0
    """[s]"""
    retreat_height: float = 0.08
    clearance: float = 0.05
    """Between the arm and what the camera saw on its way [m]."""
    arm_radius: float = 0.06
    """Of hand and forearm, at least [m]."""
    reach_of_ways: float = 0.95
    """How far from the shoulder's place at rest a way may lead over something [m]."""
    blend_time: float = 2.0
    """From the command in force to the controller's own, after each start [s]."""
    ahead_time: float = 0.0
    """The command is the posture this far ahead [s]; the robot interpolates to it by itself."""


@dataclass(frozen=True)
class GuardLimits:
    """What makes the robot hold, and after which time. Ours, not SEIKO's."""

    position_margin: float = 0.05
    """Beyond the limits of the URDF [rad]."""
    position_time: float = 0.01
    """[s]"""
    velocity_time: float = 0.02
    """Faster than the URDF allows [s]."""
    torque_factor: float = 1.05
    """Of the effort limit."""
    torque_time: float = 0.02
    following_error: float = 0.2
    """Between command and measured angle [rad]; elasticity explains at most half of it."""
    following_time: float = 0.1
    frozen_time: float = 0.1
    """Without a change of any reading while the command moves [s]; infinity = no check."""
    refused_time: float = 0.2
    """Without a command that the driver takes [s]."""
    hand_force: float = 225.0
    """Measured on one hand [N]; 1.5 times the largest that is ever wanted."""
    hand_time: float = 0.1
    failed_programs: int = 25
    """In a row."""


@dataclass(frozen=True)
class Parameters:
    """All of them."""

    weights: Weights = field(default_factory=Weights)
    limits: Limits = field(default_factory=Limits)
    clamps: Clamps = field(default_factory=Clamps)
    filters: Filters = field(default_factory=Filters)
    motion: Motion = field(default_factory=Motion)
    push: Push = field(default_factory=Push)
    supervision: Supervision = field(default_factory=Supervision)
    guards: GuardLimits = field(default_factory=GuardLimits)
    force_control: ForceParameters = field(default_factory=ForceParameters)
