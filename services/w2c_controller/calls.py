"""The calls that the controller answers, each on a thread of its own beside the loop."""

import logging
import time

from w2c import topics
from w2c.bus import Bus
from w2c.bus.interface import CallContext
from w2c.errors import CallError, UnavailableError
from w2c.messages import (
    Empty,
    GoalReply,
    PlaceGoal,
    PreviewReply,
    ReleaseGoal,
    ResumeReply,
    StopReply,
    StopRequest,
)
from w2c_controller.controller import Controller
from w2c_controller.goals.goals import check_end_effector
from w2c_controller.preview.preview import preview
from w2c_controller.preview.removal import check_removal, stays_there
from w2c_controller.preview.search_process import SearchProcess

RESUME_PATIENCE_S = 0.5

log = logging.getLogger("w2c.controller")


class Calls:
    """Goals, previews, stop and resume."""

    controller: Controller
    """Of the robot that is there now"""

    def __init__(self, bus: Bus, search: SearchProcess) -> None:
        self._bus = bus
        self._search = search

    def serve(self) -> None:
        """Take calls from now on."""
        self._bus.serve(topics.PLACE, self.place)
        self._bus.serve(topics.RELEASE, self.release)
        self._bus.serve(topics.CONTROLLER_STOP, self.stop)
        self._bus.serve(topics.CONTROLLER_RESUME, self.resume)
        self._bus.serve(topics.PREVIEW, self.preview)

    def place(self, request: PlaceGoal, _: CallContext) -> GoalReply:
        """Admit a goal. Raises GoalRefusedError."""
        self._check_removal(request.end_effector, request)
        return self.controller.requests.place(request)

    def release(self, request: ReleaseGoal, _: CallContext) -> GoalReply:
        """Admit the wish to take an end effector off. Raises GoalRefusedError."""
        self._check_removal(request.end_effector)
        return self.controller.requests.release(request)

    def stop(self, request: StopRequest, context: CallContext) -> StopReply:
        """Hold at once, and have the driver hold, which outlives this process."""
        self.controller.freeze(request.reason)
        log.warning("stop from %s: %s", context.caller, request.reason or "no reason given")
        try:
            return self._bus.call(topics.ROBOT_STOP, request).message
        except CallError as error:
            raise UnavailableError(
                f"the controller holds, but the driver did not acknowledge the stop ({error}); "
                "try again, or go on with: w2c resume"
            ) from error

    def resume(self, _request: Empty, context: CallContext) -> ResumeReply:
        """End what holds the robot until an operator says so."""
        log.warning("resume from %s", context.caller)
        self.controller.resume()
        deadline = time.monotonic() + RESUME_PATIENCE_S
        while (holding := self.controller.requests.situation.holding) and (
            time.monotonic() < deadline
        ):
            time.sleep(0.02)
        return ResumeReply(holding=bool(holding), text=holding)

    def preview(self, request: PlaceGoal, _: CallContext) -> PreviewReply:
        """Search on a copy of the desired state, in a process of its own: the loop goes on."""
        state = self.controller.desired_copy(timeout_s=1.0)
        return self._search.ask(preview, state, request)

    def _check_removal(self, end_effector: str, goal: PlaceGoal | None = None) -> None:
        """Refuse to take away a contact without which the robot would not stand.

        On a copy of the desired state, before the loop hears of it. What cannot begin anyway is
        left to the admission, which says why.
        """
        controller, contact = self.controller, check_end_effector(end_effector)
        now = controller.requests.situation
        moves = now.ready and not (now.stopped or now.stale or now.holding)
        if not moves or not now.enabled[contact] or controller.requests.last_support(contact):
            return
        state = controller.desired_copy(timeout_s=1.0)
        if goal is None or not self._search.ask(stays_there, state, goal):
            self._search.ask(check_removal, state, contact)
