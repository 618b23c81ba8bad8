"""What the operator says: stop, and go on. Said on any thread, obeyed by the loop."""

from w2c.messages.robot import DriverMode
from w2c_controller.safety.hazards import Hazard, Holds

STOPPED = "stopped by the operator"


class Stop:
    """A stop lasts until the driver was stopped and resumed, or an operator says resume here."""

    def __init__(self) -> None:
        self._asked = False
        self._resume_asked = False
        self._reason = STOPPED

    def ask(self, reason: str) -> None:
        """Hold from the next tick on."""
        self._reason = f"stopped: {reason}" if reason else STOPPED
        self._asked = True

    def resume(self) -> None:
        """End this, and other holds that wait for an operator, at the next tick."""
        self._resume_asked = True

    def inherit(self, previous: "Stop") -> None:
        """Go on with a stop of the controller before this one that did not reach the driver."""
        if previous._asked and not self._asked:
            self._asked, self._reason = True, previous._reason

    def obey(self, mode: DriverMode, holds: Holds, tick: int) -> bool:
        """Begin or end what the operator asked for; returns whether it was to go on."""
        if mode == "stopped":
            # From here on the driver's own mode says when to go on.
            self._asked = self._resume_asked = False
            holds.found(Hazard("stopped", self._reason), tick)
            return False
        resumed, self._resume_asked = self._resume_asked, False
        if self._asked and not resumed:
            holds.found(Hazard("stopped", self._reason), tick)
            return False
        if not resumed and not holds.active("stopped"):
            return False
        self._asked = False
        self._reason = STOPPED
        holds.resume(tick)
        return True
