"""What the operator says in scenario (a), and what must come of it, as data."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Line:
    """One utterance of the operator."""

    text: str
    expect: Literal["target", "motion"]
    """target: a point is proposed. motion: the robot goes there."""
    wanted: Literal["book", "cup"] | None = None
    """The thing that is meant, for who asks; None: the words are a yes"""
    changes: bool = False
    """The words change the shown point"""
    again: str = ""
    """The same in other words, for a question that no option fits"""
    picture: str = ""
    """Name of the picture to take when the motion has ended"""


SCENARIO_A = (
    Line(
        "Place your right hand on top of the book",
        "target",
        wanted="book",
        again="put your right hand on the book",
    ),
    Line(
        "move a bit to the left",
        "target",
        wanted="book",
        changes=True,
        again="a bit to the left",
    ),
    Line("that's perfect", "motion", picture="leaning"),
    Line(
        "with your left hand, reach for the cup",
        "target",
        wanted="cup",
        again="go with your left hand for the cup",
    ),
    Line("yes", "motion", picture="reaching"),
)
