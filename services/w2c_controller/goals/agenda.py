"""From what was admitted to what is under way: goals begin, end, and are told of."""

import numpy as np
import numpy.typing as npt

from w2c_controller.goals.requests import Request, Requests, Situation
from w2c_controller.safety.hazards import Holds
from w2c_controller.switching.events import Event, EventState
from w2c_controller.whole_body import WholeBody

Vector = npt.NDArray[np.float64]


class Agenda:
    """Hands admitted requests to the body at their tick. For the loop."""

    def __init__(self, requests: Requests, body: WholeBody) -> None:
        self._requests = requests
        self._body = body
        self._events: list[Event] = []
        self._ready = False

    def open(self) -> None:
        """Goals may begin from now on: the controller has begun with the robot."""
        self._ready = True

    def begin_due(self, tick: int, holds: Holds) -> None:
        """Begin what was asked for this tick, in turn; what conflicts with another is aborted."""
        for request in self._requests.due(tick):
            conflict = self._requests.conflict(request.effector)
            if conflict:
                self._events.append(_event(request, "aborted", conflict))
                continue
            self._events.append(_event(request, "accepted"))
            if request.goal is not None:
                self._body.switching.place(request.goal)
            else:
                self._body.switching.release(request.goal_id, request.effector)
            self._publish(tick, holds, self._requests.situation.desired)

    def advance(self) -> None:
        """Advance what is under way by one tick."""
        self._events.extend(self._body.switch())

    def abort(self, reason: str) -> None:
        """End what is under way and what waits."""
        for request in self._requests.clear():
            self._events.append(_event(request, "aborted", reason))
        if self._ready:
            self._body.switching.abort(reason)
            self.advance()

    def publish(self, tick: int, holds: Holds) -> None:
        """Let those who admit goals know what is under way at the end of a tick."""
        if not self._ready:
            self._requests.situation = Situation(tick=tick, holding=holds.text())
            return
        self._publish(tick, holds, (tick, self._body.retargeting.state.q.copy()))

    def _publish(self, tick: int, holds: Holds, desired: tuple[int, Vector] | None) -> None:
        switching = self._body.switching
        self._requests.situation = Situation(
            tick=tick,
            ready=True,
            stopped=holds.active("stopped"),
            holding=holds.text(),
            busy_id=switching.busy_with(),
            busy_effector=switching.busy_effector(),
            away=self._body.away(),
            enabled=self._body.retargeting.state.enabled,
            desired=desired,
        )

    def take_events(self) -> list[Event]:
        """Return what happened to goals since the last call."""
        if not self._events:
            return []
        events, self._events = self._events, []
        return events


def _event(request: Request, state: EventState, reason: str = "") -> Event:
    task = request.goal.task if request.goal is not None else "contact"
    return Event(request.goal_id, request.effector, task, state, reason)
