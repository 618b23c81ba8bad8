"""End-effector selector: which hand or foot, to touch or to lean (paper, "Control Module")."""

from w2c.messages import Array, EndEffector, Task
from w2c_dialogue.answers import EffectorAnswer, read
from w2c_dialogue.interfaces import LanguageModel
from w2c_dialogue.prompts.base import PromptSet
from w2c_dialogue.utterance import Utterance


def choose_effector(
    model: LanguageModel, prompts: PromptSet, utterance: Utterance
) -> tuple[EndEffector | None, Task]:
    """Return the end effector that an instruction names, None for none, and the task.

    Raises ModelError, CallError.
    """
    answer = read(model.complete(prompts.effector(utterance)), EffectorAnswer)
    return (None if answer.effector == "unspecified" else answer.effector), answer.task


def nearest_hand(point: Array) -> EndEffector:
    """Return the hand on the side of a point (3,) in the world [m]; y is to the left."""
    return "right_hand" if point[1] < 0.0 else "left_hand"


def task_of(limb: EndEffector, task: Task) -> Task:
    """Return what a limb can do: a foot stands, whatever the words for it."""
    return "contact" if limb in ("left_foot", "right_foot") else task
