"""What is asked before the controller gets a goal: what stands there, and how it will end."""

import logging

import msgspec

from w2c.errors import RefusedError, W2CError
from w2c.messages import PlaceGoal
from w2c_dialogue.frames import FrameStore
from w2c_dialogue.steps import Services

log = logging.getLogger("w2c.dialogue")


def with_obstacles(goal: PlaceGoal, frames: FrameStore, services: Services) -> PlaceGoal:
    """Return the goal with the heights that the newest picture shows; without, where none come."""
    try:
        newest = frames.find(-1)
        return msgspec.structs.replace(goal, obstacles=services.heights(newest))
    except W2CError as error:
        log.warning(
            "goal without obstacles: the way is not checked",
            extra={"goal": goal.goal_id, "reason": str(error)},
        )
        return goal


def foresee(goal: PlaceGoal, services: Services) -> str:
    """Return what the operator should know of how a goal will end; "" = well, or nobody knows.

    A hand that reaches goes as near as it can: the operator may want that. A support that cannot
    be leaned on is of no use.

    Raises:
        RefusedError: the support cannot be leaned on; says why.
    """
    try:
        preview = services.preview(goal)
    except W2CError as error:
        log.warning("goal without preview", extra={"goal": goal.goal_id, "reason": str(error)})
        return ""
    if preview.reachable:
        return f" Beware: {preview.reason}." if preview.reason else ""
    limb = goal.end_effector.replace("_", " ")
    if goal.task == "contact":
        raise RefusedError(
            f"My {limb} cannot lean there: {preview.reason}. I did not move. Correct the target, "
            "or give me another support first."
        )
    return f" I do not expect to get there: {preview.reason}."
