"""A simulated robot and its controller in lock step, in one thread and as fast as they compute.

The two exchange the messages of the bus, state for command, and are bit-identical with the two
processes that exchange them over it: what is left out is their encoding, 0.4 of 1.2 ms a tick.
"""

from collections.abc import Callable, Collection
from typing import Any

from w2c.errors import GoalRefusedError
from w2c.messages import PlaceGoal, ReleaseGoal


class ClosedLoop:
    """See the module. `robot` is a simulator, `controller` answers its states."""

    def __init__(self, robot: Any, controller: Any) -> None:
        self.robot = robot
        self.controller = controller
        self.events: list[Any] = []
        """Of all goals, in order"""
        self._command_tick = -1

    def run(
        self,
        ticks: int,
        *,
        until: Collection[str] = (),
        watch: Callable[[], bool] = lambda: False,
    ) -> str:
        """Go on for some ticks, or until something happens.

        Args:
            ticks: at most.
            until: states of a goal that end it.
            watch: called after each tick; True ends it.

        Returns:
            The state that ended it, or "".
        """
        for _ in range(ticks):
            mode = "tracking" if self._command_tick >= 0 else "holding"
            state = self.robot.state(command_tick=self._command_tick, mode=mode)
            command = self.controller.tick(state)
            self._command_tick = command.tick
            self.robot.step(command.position)
            events = self.controller.take_events()
            self.events += events
            if watch():
                return ""
            for event in events:
                if event.state in until:
                    return str(event.state)
        return ""

    def ask(self, goal: PlaceGoal | ReleaseGoal) -> str:
        """Give the controller a goal. Returns why it refused it, or ""."""
        requests = self.controller.requests
        try:
            if isinstance(goal, PlaceGoal):
                requests.place(goal)
            else:
                requests.release(goal)
        except GoalRefusedError as error:
            return str(error)
        return ""
