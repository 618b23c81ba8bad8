"""Numbers of push mode and of the supervision of contacts."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Push:
    """How a commanded normal force is approached; values of SEIKO where it has one."""

    lead: float = 5.0
    """How far the target runs ahead of the desired force [N]: anti-windup."""
    low_pass_hz: float = 2.0
    rate: float = 10.0
    """[N/s]"""
    acceleration: float = 100.0
    """[N/s^2]"""
    desired_tolerance: float = 1.0
    """Between command and desired force, to count as loaded [N]. Ours."""
    tolerance: float = 5.0
    """Between command and measured force, to count as loaded [N]. Ours."""
    tolerance_share: float = 0.1
    """Of the command; the larger of both counts. Ours."""


@dataclass(frozen=True)
class Supervision:
    """When a contact counts as lost, slipping or overloaded. Ours: SEIKO does not look."""

    lost_desired: tuple[float, float] = (50.0, 20.0)
    """Foot, hand: a contact that shall carry more is missed [N]."""
    lost_measured: tuple[float, float] = (10.0, 3.0)
    """Foot, hand: a contact that carries less has no ground [N]."""
    lost_time: float = 0.2
    """Of a foot, and of a hand that shall carry 20 N; of one that shall carry n times as much, the
    n-th part [s]."""
    slip_distance: tuple[float, float] = (0.003, 0.006)
    """Foot, hand: of motion against the feet within `slip_window`, rolling apart [m]. In far
    reaches a foot creeps by 0.3 mm; a ball that turns is drawn over the table by up to 5 mm."""
    slip_window: float = 0.5
    """Time constant after which a motion counts as place [s]."""
    creep_distance: float = 0.003
    """Of a hand within `creep_window`, where it should stick [m]."""
    creep_window: float = 5.0
    """An arm that winds up draws its hand by 2 mm/s [s]."""
    creep_cone: float = 0.75
    """It should where the force along the surface is within this share of the assumed friction;
    the measured force is a tenth off."""
    slip_load: float = 25.0
    """A hand of which less is wanted may hop about, as it does at the touch [N]."""
    slip_again: float = 3.0
    """A hand that slips again within this time is unloaded [s]."""
    overload_force: float = 195.0
    """Measured normal force on a hand [N]; 1.3 times the largest that is ever wanted."""
    overload_time: float = 0.3
    """[s]"""
    falls_ahead: float = 0.08
    """A robot whose centre of mass is farther ahead of the middle of its soles falls when its hand
    loses its support [m]: it stood at 7.4 cm, and fell at 8.9. For previews."""
    bump_settle: float = 0.5
    """Time constant with which the reading of a free effector becomes its zero [s]."""
