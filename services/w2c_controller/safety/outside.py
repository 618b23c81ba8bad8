"""What the process finds between two ticks; the controller in it has no clock, and cannot.

The numbers are read off the wall clock and the bus, so nobody can compute them again. All else that
is said of a finding follows from them: whoever makes a recorded one again needs value and limit.
"""

from typing import Final

from w2c.errors import ControlError
from w2c.messages.control import SafetyCause
from w2c_controller.safety.hazards import Hazard

STALE: Final[SafetyCause] = "state_stale"
OUT_OF_ORDER: Final[SafetyCause] = "state_out_of_order"
OUTSIDE: Final = (STALE, OUT_OF_ORDER)


def silence(silence_ms: float, limit_ms: float) -> Hazard:
    """Return that no state came for longer than allowed."""
    text = f"no state of the robot for {silence_ms:.0f} ms: not commanding"
    return Hazard(STALE, text, "driver", silence_ms, limit_ms, "ms")


def out_of_order(tick: int, answered: int) -> Hazard:
    """Return that a state came after a newer one was answered."""
    text = f"the state of tick {tick} came after that of {answered}"
    return Hazard(OUT_OF_ORDER, text, "", tick, answered, "ticks")


def found_outside(cause: SafetyCause, value: float, limit: float) -> Hazard:
    """Return a finding by what was measured, as it is recorded.

    Raises:
        ControlError: the cause is none of `OUTSIDE`: the controller finds it, given the states.
    """
    if cause == STALE:
        return silence(value, limit)
    if cause == OUT_OF_ORDER:
        return out_of_order(round(value), round(limit))
    raise ControlError(
        f"'{cause}' is found by the controller in its states, not by the process: expected one of "
        f"{', '.join(OUTSIDE)}"
    )
