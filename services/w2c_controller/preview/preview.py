"""Whether a goal can be met from here, and if not, what is in the way of it."""

import numpy as np

from w2c.errors import ControlError
from w2c.geometry import frame_from_normal
from w2c.messages import PlaceGoal, PreviewReply
from w2c_controller.goals.goals import Goal, check_place
from w2c_controller.motion.grasp import pointing_rotation
from w2c_controller.parameters import HANDS
from w2c_controller.preview.search import StaticSearch
from w2c_controller.seiko.contacts import normal_force_limits
from w2c_controller.seiko.desired import DesiredState
from w2c_controller.switching.blocking import spoken


def preview(search: StaticSearch, state: DesiredState, message: PlaceGoal) -> PreviewReply:
    """Return what a goal would come to, going on from a desired state; the state stays as it is.

    A reach is possible where the hand gets within the distance that counts as reached; a contact,
    where it also takes its smallest load there. One that is possible, and where the robot would
    fall without a hand, says so.
    """
    try:
        goal = check_place(message, search.controlled.hand_radius)
    except ControlError as error:
        return PreviewReply(reachable=False, distance=-1.0, reason=str(error))
    search.start_from(state)
    if not search.free(goal.effector):
        left = float(search.state.wrenches[goal.effector, 2])
        return PreviewReply(
            reachable=False,
            distance=_distance(search, goal),
            reason=f"the {_name(goal)} leans with {left:.0f} N that the other contacts cannot "
            "carry; choose the other hand, or lean there first",
        )
    if goal.task == "reach":
        aim(search, goal)
    distance = search.move(goal.effector, goal.target)
    stands = search.stands()
    if distance > search.parameters.motion.reached_distance or not stands:
        return PreviewReply(reachable=False, distance=distance, reason=_short(search, goal, stands))
    if goal.task == "contact":
        return _preview_load(search, goal, distance)
    return PreviewReply(reachable=True, distance=distance, reason=_beware(search))


def aim(search: StaticSearch, goal: Goal) -> None:
    """Turn a hand as it would be turned to reach for a goal."""
    search.state.target_rotations[goal.effector] = pointing_rotation(goal.fingers)


def _preview_load(search: StaticSearch, goal: Goal, distance: float) -> PreviewReply:
    """Return whether an end effector that is at its support can bear weight there."""
    force = search.load(goal.effector, frame_from_normal(goal.normal))
    least, _ = normal_force_limits(search.parameters.limits, goal.effector)
    if force >= least:
        return PreviewReply(reachable=True, distance=distance, reason=_beware(search))
    return PreviewReply(
        reachable=False,
        distance=distance,
        reason=f"the {_name(goal)} gets there, but would bear {max(force, 0.0):.0f} N where "
        f"{least:.0f} N are needed{_because(search)}. Choose a point nearer to the body",
    )


def _beware(search: StaticSearch) -> str:
    """Return what a posture that leans far ahead depends on; "" = it would stand without hands."""
    hands = [spoken(k) for k in HANDS if search.state.enabled[k]]
    ahead, farthest = search.lead(), search.parameters.supervision.falls_ahead
    if not hands or ahead <= farthest:
        return ""
    return (
        f"the robot leans {100 * ahead:.1f} cm ahead of its feet, limit {100 * farthest:.1f} cm: "
        f"if the {' or the '.join(hands)} lost its support, it would fall"
    )


def _short(search: StaticSearch, goal: Goal, stands: bool) -> str:
    """Return the words for a point that is out of reach."""
    gap = goal.target - search.position(goal.effector)
    cause = _because(search) if stands else ": no posture was found that stands there"
    return f"the {_name(goal)} ends {100 * np.linalg.norm(gap):.1f} cm short of the point{cause}"


def _because(search: StaticSearch) -> str:
    """Return the limits at work, as the end of a sentence."""
    found = search.limits_reached()
    return f": {'; '.join(found)}" if found else ""


def _distance(search: StaticSearch, goal: Goal) -> float:
    return float(np.linalg.norm(search.position(goal.effector) - goal.target))


def _name(goal: Goal) -> str:
    return goal.end_effector.replace("_", " ")
