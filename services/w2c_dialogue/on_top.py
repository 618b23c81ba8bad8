"""On top of a thing: above the middle of what is seen of it.

A robot looks down at things. The middle of what it sees of a toolbox is its front; its lid is above
that. What is flat lies open as a whole, and a point a little above its middle is still on it.
"""

import numpy as np

from w2c.messages import PhraseEvidence
from w2c_dialogue.cells import middles
from w2c_dialogue.heat import hot
from w2c_dialogue.utterance import Mention, Utterance

HEIGHT = 0.33
"""Of the point within the outline, from its upper edge"""
NEARLY = 0.12
"""As far above and below that hot cells are looked at, as a share of the outline"""
_ARTICLES = frozenset({"the", "a", "an", "that", "this", "your", "my", "our"})
_ON_TOP = (
    "on top of", "on the top of", "onto the top of", "to the top of", "at the top of", "ontop of",
    "atop", "on top", "on the upper side of", "on the top side of", "on the top surface of",
)  # fmt: skip


def says_on_top(utterance: Utterance, mention: Mention) -> bool:
    """Whether the words before a thing's name put the place on top of it."""
    if mention.span is None:
        return False
    before = list(utterance.folded[: mention.span[0] - 1])
    while before and before[-1] in _ARTICLES:
        before.pop()
    said = " ".join(before)
    return any(said == words or said.endswith(f" {words}") for words in _ON_TOP)


def upper_point(seen: PhraseEvidence, size: tuple[int, int]) -> tuple[float, float] | None:
    """Return the point (u, v) of what is seen of a thing that is on top of it [px].

    Args:
        seen: Of the thing, its box first.
        size: Width and height of the picture [px].

    Returns:
        None where nothing is known of its outline.
    """
    if not seen.boxes or seen.heatmap is None or not seen.heatmap.any():
        return None
    box = seen.boxes[0]
    rows, columns = np.nonzero(hot(seen.heatmap))
    u, v = middles(rows, columns, seen.heatmap.shape, size)
    wanted = box.top + HEIGHT * (box.bottom - box.top)
    reach = max(NEARLY * (box.bottom - box.top), size[1] / len(seen.heatmap))
    near = (np.abs(v - wanted) <= reach) & (u >= box.left) & (u < box.right)
    if not near.any():
        return None
    u, v = u[near], v[near]
    # The hot cell next to the middle of them: between two horns there may be nothing.
    index = int(np.argmin(np.hypot(u - u.mean(), v - wanted)))
    return float(u[index]), float(v[index])
