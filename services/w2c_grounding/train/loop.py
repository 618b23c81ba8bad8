"""What all trainings do alike: steps until the plan is done, with reports and checkpoints."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from w2c.clock import Clock
from w2c.errors import ConfigError, ModelError
from w2c_grounding.train.plan import Plan, Progress, learning_rate

MOST_SKIPPED = 20
"""Steps without a finite gradient, after which something is wrong with rate or data"""


class TrainingLoop(ABC):
    """A training of which a subclass knows the steps."""

    def __init__(self, plan: Plan, clock: Clock, started_ns: int) -> None:
        """`started_ns` is when the command began."""
        self.progress = Progress()
        self._plan = plan
        self._clock = clock
        self._started_ns = started_ns
        self._earlier_s = 0.0
        self._skipped = 0

    @abstractmethod
    def step(self) -> float:
        """Take one step; returns the loss. Raises ModelError as `skip` does."""

    def run(
        self,
        save: Callable[[], None],
        report: Callable[[str], None],
        stopped: Callable[[], bool] = lambda: False,
    ) -> bool:
        """Train until the plan is done; return whether it is.

        Args:
            save: Called between checkpoints, and at the end.
            report: Takes a line for people now and then.
            stopped: Asked after every step; True ends the training, to be resumed.

        Raises:
            ModelError: what a step raises.
        """
        self.look_at_clock()
        if self.progress.steps == 0:
            self.progress.began = self.progress.seconds
        reported = saved = self.progress.seconds
        losses: list[float] = []
        while self.progress.fraction(self._plan) < 1.0 and not stopped():
            losses.append(self.step())
            seconds = self.look_at_clock()
            if seconds - reported >= self._plan.report_s:
                report(self._line(losses))
                reported = seconds
                losses.clear()
            if seconds - saved >= self._plan.save_s:
                save()
                saved = self.look_at_clock()
        save()
        return self.progress.fraction(self._plan) >= 1.0

    def look_at_clock(self) -> float:
        """Note the time, and return the seconds that were spent."""
        passed_s = (self._clock.now_ns() - self._started_ns) * 1e-9
        self.progress.seconds = self._earlier_s + passed_s
        return self.progress.seconds

    @abstractmethod
    def load(self, state: Mapping[str, Any]) -> None:
        """Take what a step has changed from a saved state; any exception: it does not fit."""

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from a saved state. Raises ConfigError where it does not fit."""
        try:
            self.load(state)
            self.progress = Progress(**state["progress"])
        except (KeyError, RuntimeError, ValueError, TypeError) as error:
            raise ConfigError(
                f"the state is of another training, model or kinds of objects: {error}; train "
                "without --resume"
            ) from error
        self._earlier_s = self.progress.seconds

    def skip(self, rate: float, most: int = MOST_SKIPPED) -> None:
        """Count a step that changes no weight, as its gradients are not finite.

        Raises:
            ModelError: there were more such steps than `most`.
        """
        self._skipped += 1
        if self._skipped > most:
            raise ModelError(
                f"no finite gradient in {self._skipped} of {self.progress.steps + 1} steps, at a "
                f"learning rate of {rate:.1e}: resume with a lower --rate"
            )

    def _line(self, losses: Sequence[float]) -> str:
        progress = self.progress
        return (
            f"{progress.seconds / 60:.1f} min, {100 * progress.fraction(self._plan):.0f} %, "
            f"step {progress.steps}, loss {np.mean(losses):.3f}, "
            f"rate {learning_rate(self._plan, progress):.1e}"
        )
