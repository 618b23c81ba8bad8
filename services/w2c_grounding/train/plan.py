"""How to train: the numbers, and how far a training is."""

import math
from dataclasses import dataclass
from pathlib import Path

NAME = "w2c-clipseg-12"
"""Of what is trained, where nobody gives it another"""

_CPU_FLAGS = Path("/proc/cpuinfo")
_BF16_FLAGS = {"avx512_bf16", "amx_bf16", "bf16"}
"""Of processors that multiply bfloat16; elsewhere it takes nearly three times as long as float32"""


@dataclass(frozen=True)
class Plan:
    """How to train."""

    minutes: float = 60.0
    """Wall time of the whole command, over all resumptions"""
    steps: int = 0
    """Ends after so many steps instead; the schedule counts them, the minutes do not matter"""
    seed: int = 0
    windows: int = 24
    """Windows of pictures in a step; of whole pictures there are as many as have their patches"""
    window_cells: int = 11
    """Side of a window [patches]: a quarter of the picture"""
    whole_from: float = 0.72
    """Share of the training from which on all steps see whole pictures"""
    whole_share: float = 0.1
    """Of the steps before that"""
    present: int = 4
    """Phrases per picture that fit something"""
    absent: int = 2
    """Phrases per picture that fit nothing"""
    rate: float = 1.5e-3
    """Highest learning rate"""
    warm_up: int = 100
    """Steps in which the rate rises"""
    weight_decay: float = 0.02
    closing_s: float = 150.0
    """Kept back from the minutes for threshold and scores, at most a tenth of them"""
    save_s: float = 280.0
    """Between checkpoints and looks at kept pictures"""
    report_s: float = 60.0
    words_only: bool = False
    """Whether what sees pictures stays as it is, and only what is said of them is learned"""
    bf16: bool = False
    """Whether products are in bfloat16"""

    def wholes(self, cells: int) -> int:
        """Return the number of whole pictures in a step, of `cells` patches along a side."""
        return max(1, round(self.windows * self.window_cells**2 / cells**2))

    @property
    def last_s(self) -> float:
        """Return when the last step is to end, from the beginning of the command on."""
        return 60.0 * self.minutes - min(self.closing_s, 6.0 * self.minutes)


@dataclass
class Progress:
    """Where a training is; travels in the checkpoint."""

    steps: int = 0
    seconds: float = 0.0
    """Wall time from the beginning of the command, without what passed between its parts"""
    began: float = 0.0
    """`seconds` at the first step"""

    def fraction(self, plan: Plan) -> float:
        """Return how much of the plan is done, 0 to 1."""
        if plan.steps:
            return min(self.steps / plan.steps, 1.0)
        length = plan.last_s - self.began
        return min((self.seconds - self.began) / length, 1.0) if length > 0.0 else 1.0


def learning_rate(plan: Plan, progress: Progress) -> float:
    """Return the rate of the next step: a rise over the first steps, then half a cosine down."""
    rise = min(1.0, (progress.steps + 1) / plan.warm_up)
    cosine = 0.5 * (1.0 + math.cos(math.pi * progress.fraction(plan)))
    return plan.rate * rise * (0.01 + 0.99 * cosine)


def has_bf16() -> bool:
    """Whether this processor multiplies bfloat16; False where Linux does not say."""
    try:
        lines = _CPU_FLAGS.read_text().splitlines()
    except OSError:
        return False
    flags = next((line for line in lines if line.lower().startswith(("flags", "features"))), "")
    return bool(set(flags.split()) & _BF16_FLAGS)
