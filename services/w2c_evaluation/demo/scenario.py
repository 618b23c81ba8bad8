"""What the operator says in scenario (a), and what must come of it, as data."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Line:
    """One utterance of the operator."""

    text: str
    expect: Literal["target", "motion"]
    """target: a point is proposed. motion: the robot goes there."""
    picture: str = ""
    """Name of the picture to take when the motion has ended"""


SCENARIO_A = (
    Line("Place your right hand on top of the book", "target"),
    Line("move a bit to the left", "target"),
    Line("that's perfect", "motion", picture="leaning"),
    Line("with your left hand, reach for the cup", "target"),
    Line("yes", "motion", picture="reaching"),
)
