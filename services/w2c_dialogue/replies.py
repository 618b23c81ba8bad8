"""Sentences to the operator: short, what was understood, what to do next."""

from w2c.errors import DeadlineError, ModelError, RefusedError, UnavailableError, W2CError
from w2c.messages import EndEffector, Target, Task
from w2c_dialogue.conversation import Goal

SERVICES = {
    "selector": "language model",
    "analyzer": "language model",
    "relative": "language model",
    "correction": "language model",
    "effector": "language model",
    "grounding": "grounding service",
    "veto": "grounding service",
    "lift": "perception",
    "allowed": "perception",
    "heights": "perception",
    "preview": "controller",
    "place": "controller",
}
"""Who does the work of a step."""
_ASK = "Say yes or press Confirm to go there, or correct me."


def failure(error: W2CError, step: str) -> str:
    """Return why a turn failed at a step, and what to do."""
    service = SERVICES.get(step, "system")
    if isinstance(error, RefusedError):
        return str(error)
    if isinstance(error, ModelError):
        return f"I could not follow that ({error}). Nothing changed; please say it in other words."
    if isinstance(error, UnavailableError):
        return (
            f"The {service} cannot be asked now ({error}). "
            "Nothing changed; look at `w2c status` and say it again."
        )
    if isinstance(error, DeadlineError):
        return (
            f"The {service} did not answer in time ({error}). Nothing changed; please say it again."
        )
    return f"The {service} failed ({error}). Nothing changed; look at `w2c status`."


def proposal(target: Target, position: str) -> str:
    """Return the answer to a new instruction."""
    names = " and ".join(f"'{phrase}'" for phrase in target.phrases)
    where = (
        f"on {names}"
        if position == "absolute" and names
        else f"relative to {names}"
        if names
        else "here"
    )
    return _with_warning(f"I understood the point shown, {where}.", target)


def correction(target: Target, du: float, dv: float) -> str:
    """Return the answer to a correction by (du, dv) [px]."""
    parts = []
    if abs(du) >= 0.5:
        parts.append(f"{abs(du):.0f} px {'right' if du > 0 else 'left'}")
    if abs(dv) >= 0.5:
        parts.append(f"{abs(dv):.0f} px {'down' if dv > 0 else 'up'}")
    return _with_warning(f"Moved {' and '.join(parts) or 'to the border of the picture'}.", target)


def confirmed(
    effector: EndEffector, task: Task, *, assumed: str, outlook: str = "", turns: bool = False
) -> str:
    """Return the answer to a yes.

    Args:
        effector: What goes there.
        task: What for.
        assumed: Why this limb, where none was named; "" = it was named.
        outlook: How it will end where that is not well.
        turns: It was on its way to another target.
    """
    limb = effector.replace("_", " ")
    stands = effector in ("left_foot", "right_foot")
    verb = "step there" if stands else "lean on it" if task == "contact" else "reach for it"
    side = f" You named no hand; I take the {limb}, {assumed}." if assumed else ""
    turn = "turn to the new target and " if turns else ""
    return f"I {turn}{verb} with my {limb}.{outlook}{side} Say stop to hold."


def meanwhile(goal: Goal) -> str:
    """Return what to know of a target that is shown while the robot moves to another."""
    limb = goal.effector.replace("_", " ")
    if goal.touching:
        return (
            f" My {limb} touches at the old target already, and goes on there until you confirm; "
            "then it lifts off first."
        )
    return f" Until you confirm, my {limb} goes on to the old target; say stop to hold."


def dropped(goal: Goal | None, *, question: bool = False) -> str:
    """Return the answer to "never mind".

    Args:
        goal: The robot is on its way to another target; None: it is not.
        question: A question was dropped, instead of a target.
    """
    what = "the question" if question else "the target"
    if goal is None:
        return f"I dropped {what}; nothing moves. Tell me another place when you like."
    limb = goal.effector.replace("_", " ")
    return f"I dropped {what}. My {limb} goes on to the one you confirmed; say stop to hold."


def arrived(goal: Goal, target: Target, *, shown: bool) -> str:
    """Return what to say when a goal is over; `shown`: another target waits for a yes."""
    limb = goal.effector.replace("_", " ")
    later = " The target on the screen is a new one: say yes to go there." if shown else ""
    if target.state == "in_contact":
        return f"My {limb} is in contact and carries weight.{later}"
    if target.state == "reached":
        return f"My {limb} has reached the target.{later}"
    reason = target.warning or "the controller ended the motion"
    return f"I gave up on the target: {reason}.{later or ' Name another place.'}"


def _with_warning(text: str, target: Target) -> str:
    warning = f" {target.warning}" if target.warning else ""
    return f"{text}{warning} {_ASK}" if target.point is not None else f"{text}{warning}"
