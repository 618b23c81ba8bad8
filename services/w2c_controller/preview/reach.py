"""How far a hand gets along a ray: for laying out scenes, and for choosing how far to reach."""

import numpy as np
import numpy.typing as npt

from w2c.errors import ControlError
from w2c.geometry import frame_from_normal, unit
from w2c.messages import PlaceGoal, RobotDescription
from w2c_controller.goals.goals import FARTHEST, check_end_effector, check_place
from w2c_controller.kinematics.model import build_model
from w2c_controller.motion.grasp import approach_direction, pointing_rotation
from w2c_controller.parameters import HANDS, Parameters
from w2c_controller.preview.search import StaticSearch

Vector = npt.NDArray[np.float64]

STRIDE = 0.05
"""Between two points of the ray that are tried [m]."""
RESOLUTION = 0.002
"""Of the distance found [m]."""
ON_TARGET = 0.01
"""A hand this close to a point of the ray is there [m]."""


def farthest_reach(
    description: RobotDescription,
    *,
    end_effector: str,
    origin: tuple[float, float],
    height: float,
    direction: tuple[float, float],
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0),
    support: PlaceGoal | None = None,
    parameters: Parameters | None = None,
) -> float:
    """Return how far a hand's frame gets along a horizontal ray, from the initial posture [m].

    Args:
        description: The robot.
        end_effector: left_hand or right_hand.
        origin: x, y of the ray's origin, in the world [m].
        height: Of the ray [m].
        direction: x, y of the ray; any length.
        normal: Of the surface that is reached for: the hand points into it.
        support: Where the other hand leans; None: on two feet.
        parameters: Whose limits end the reach; None: the controller's own.

    Raises:
        ControlError: an end effector that is no hand, or a support that cannot be leaned on.
    """
    hand = check_end_effector(end_effector)
    if hand not in HANDS:
        raise ControlError(f"how far the {end_effector} gets is not known; choose a hand")
    model = build_model(description)
    search = StaticSearch(model, parameters)
    search.start(description.initial_position[model.joint_indices])
    if support is not None:
        goal = check_place(support, model.hand_radius)
        _lean(search, goal.effector, goal.target, goal.normal)
    ray = unit([direction[0], direction[1], 0.0])
    start = np.array([origin[0], origin[1], height])
    rotation = pointing_rotation(approach_direction(start + ray, unit(normal)))
    search.state.target_rotations[hand] = rotation
    return sweep(search, hand, start, ray)


def sweep(search: StaticSearch, hand: int, origin: Vector, direction: Vector) -> float:
    """Return how far along a ray a hand gets from the state of a search [m]; 0: not to the ray.

    Strides outwards from the point of the ray that is nearest to the hand, each from where the
    last one ended, then halves the last stride.

    Args:
        search: On the state to start from; ends at the farthest point found.
        hand: Index of the hand.
        origin: (3,) of the ray [m].
        direction: (3,) unit.
    """
    tried = max(float((search.position(hand) - origin) @ direction), 0.0)
    while tried < FARTHEST and not _at(search, hand, origin + tried * direction):
        tried += STRIDE
    if tried >= FARTHEST:
        return 0.0
    reached = tried
    stride = STRIDE
    while stride >= RESOLUTION:
        before = search.state.copy()
        if _at(search, hand, origin + (reached + stride) * direction):
            reached += stride
        else:
            search.start_from(before)
            stride *= 0.5
    return reached


def _at(search: StaticSearch, hand: int, point: Vector) -> bool:
    return search.move(hand, point) < ON_TARGET and search.stands()


def _lean(search: StaticSearch, hand: int, target: Vector, normal: Vector) -> None:
    """Bring a hand to a support and load it. Raises ControlError."""
    distance = search.move(hand, target)
    if distance > search.parameters.motion.reached_distance:
        raise ControlError(
            f"the support at {np.round(target, 3).tolist()} cannot be reached: "
            f"{distance:.3f} m are left"
        )
    force = search.load(hand, frame_from_normal(normal))
    least = search.parameters.limits.hand_force_min
    if force < least:
        raise ControlError(f"the support takes {force:.0f} N, at least {least:.0f} N are needed")
