"""Whether a contact can be taken away: do the others balance this posture, or one near it."""

from w2c.errors import GoalRefusedError
from w2c.messages import PlaceGoal
from w2c_controller.goals.goals import check_place
from w2c_controller.parameters import HANDS
from w2c_controller.preview.search import StaticSearch
from w2c_controller.seiko.desired import DesiredState
from w2c_controller.switching.blocking import spoken


def stays_there(search: StaticSearch, state: DesiredState, message: PlaceGoal) -> bool:
    """Return whether a goal asks for the contact that is there: nothing is taken away.

    Raises:
        GoalRefusedError: the goal is none.
    """
    goal = check_place(message, search.controlled.hand_radius, search.parameters.limits)
    k = goal.effector
    normal, within = state.contact_rotations[k][:, 2], search.parameters.motion.same_contact
    return k in HANDS and goal.is_at(state.target_positions[k], normal, within)


def check_removal(search: StaticSearch, state: DesiredState, contact: int) -> None:
    """Look whether a posture stands without a contact; the state stays as it is.

    Args:
        search: Is moved.
        state: The desired state.
        contact: Index of the end effector; one that is free passes.

    Raises:
        GoalRefusedError: there is none; says what stays on the contact, and which limits hold it.
    """
    if not state.enabled[contact]:
        return
    search.start_from(state)
    weight = sum(float(state.world_force(k, search.kinematics.rotations)[2]) for k in range(4))
    if search.free(contact):
        return
    left = float(search.state.wrenches[contact, 2])
    stays = (
        f"{left:.0f} of {weight:.0f} N stay on it"
        if search.state.enabled[contact]
        else "no posture was found that stands without it"
    )
    found = search.limits_reached()
    because = f", because {'; '.join(found)}" if found else ""
    raise GoalRefusedError(
        f"the {spoken(contact)} cannot be taken off its support: {stays}{because}. "
        "Put another foot or hand on a support first"
    )
