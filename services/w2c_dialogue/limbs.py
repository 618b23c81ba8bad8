"""Which limb a target is for, and what for: heard once, then remembered."""

import threading
from collections import OrderedDict

from w2c.messages import EndEffector, Task
from w2c_dialogue import effector
from w2c_dialogue.conversation import Shown
from w2c_dialogue.interfaces import LanguageModel
from w2c_dialogue.prompts.base import PromptSet
from w2c_dialogue.utterance import parse

KEPT_INSTRUCTIONS = 32


class Limbs:
    """Answers from memory where an instruction was read before. Thread-safe."""

    def __init__(self, prompts: PromptSet) -> None:
        self._prompts = prompts
        self._lock = threading.Lock()
        self._heard: OrderedDict[str, tuple[EndEffector | None, Task]] = OrderedDict()

    def choose(self, shown: Shown, model: LanguageModel) -> tuple[EndEffector, Task, bool]:
        """Return what shall go to a target, what for, and whether the limb is only assumed.

        Raises:
            ModelError: the model's answer cannot be followed.
            CallError: the model does not answer.
        """
        named, task = shown.effector, shown.task
        if (named is None or task is None) and shown.target.instruction:
            heard = self.hear(shown.target.instruction, model)
            named, task = named or heard[0], task or heard[1]
        if named is None and shown.target.point is not None:
            return effector.nearest_hand(shown.target.point), task or "contact", True
        limb = named or "right_hand"
        return limb, effector.task_of(limb, task or "contact"), named is None

    def hear(self, instruction: str, model: LanguageModel) -> tuple[EndEffector | None, Task]:
        """Return the limb that an instruction names, None for none, and the task.

        Raises ModelError, CallError.
        """
        with self._lock:
            known = self._heard.get(instruction)
        if known is not None:
            return known
        heard = effector.choose_effector(model, self._prompts, parse(instruction))
        with self._lock:
            self._heard[instruction] = heard
            while len(self._heard) > KEPT_INSTRUCTIONS:
                self._heard.popitem(last=False)
        return heard
