"""What is told about a target beside its point: advice, and why it may not be confirmed."""

from typing import Literal

from w2c.messages.base import Array, Message, Name, Stamp, Text, check_array

AdviceCheck = Literal["veto", "surface", "material", "reach"]


class Remark(Message, frozen=True, kw_only=True):
    """One thing that was found out about a target."""

    kind: AdviceCheck
    level: Literal["fine", "caution", "veto"]
    """fine: nothing speaks against it; caution: the operator decides; veto: cannot be confirmed"""
    text: Text
    """The reason, for the operator"""
    source: Name
    """Who found it out: controller, perception, grounding or the operator's words"""
    value: float | None = None
    """What was found, in `unit`; None where there is no number"""
    limit: float | None = None
    """What it was compared with; None where the source does not tell it"""
    unit: str = ""
    """m, rad, or "" for shares and probabilities"""


class Unchecked(Message, frozen=True, kw_only=True):
    """A check that could not be made."""

    check: AdviceCheck
    reason: Text


class Advice(Message, frozen=True, kw_only=True):
    """What is known of a target besides its place. A later one for the same target replaces it."""

    stamp_ns: Stamp
    target_id: Name
    frame_stamp_ns: Stamp
    """Of the frame that the target was chosen in, and that was looked at"""
    remarks: list[Remark]
    unchecked: list[Unchecked] = []
    pending: list[AdviceCheck] = []
    """What is still being found out; empty: this is all"""
    refusal: Text = ""
    """Why a confirmation would be refused; "" = it would not, by what is known so far"""
    seconds: float
    """Since the target was published [s]"""


class VetoRequest(Message, frozen=True, kw_only=True):
    """May this point of the world be touched, by what the newest picture shows there?"""

    point: Array
    """(3,) on the surface, in the world [m]"""

    def __post_init__(self) -> None:
        """Refuse NaN, infinity and wrong shapes."""
        check_array("point", self.point, (3,))


class VetoReply(Message, frozen=True, kw_only=True):
    """What the veto list says of a point."""

    refusal: Text = ""
    """Why it is not to be touched, for the operator; "" = nothing forbids it"""
    note: Text = ""
    """What could not be looked at, for the operator"""
