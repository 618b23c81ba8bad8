"""What a detector's heads give, as evidence: the boxes, and a heatmap of them."""

import numpy as np
import numpy.typing as npt

from w2c_grounding.adapters import heatmap_from_boxes
from w2c_grounding.family import Evidence, ScoredBox

KEPT = 20
"""Best boxes of a phrase. A detector has hundreds of queries, and all but a few say "nothing"."""

_VISIBLE = 0.02
"""Weaker boxes are left out of the heatmap: a scene full of faint boxes shows nothing."""


def evidence_of_detections(
    scores: npt.NDArray[np.float32],
    boxes: npt.NDArray[np.float32],
    extent: tuple[float, float],
    size: tuple[int, int],
    unknown_words: tuple[str, ...] = (),
) -> Evidence:
    """Return the best `KEPT` detections of a phrase.

    Args:
        scores: (n,), 0 to 1.
        boxes: (n, 4), centre u, centre v, width, height as fractions of the extent.
        extent: (width, height) of what the fractions are of [px of the picture]; larger than the
            picture where the model saw it padded.
        size: (width, height) of the picture [px].
        unknown_words: Handed on.
    """
    # A score that is no number sorts last.
    best = np.argsort(-scores, kind="stable")[:KEPT]
    centres, halves = boxes[best, :2] * extent, boxes[best, 2:] * np.asarray(extent) / 2
    corners = np.concatenate([centres - halves, centres + halves], axis=1)  # (k, 4)
    found = tuple(
        ScoredBox(*(float(value) for value in row))
        for row in np.column_stack([corners, scores[best]])
    )
    visible = [box for box in found if box.score >= _VISIBLE]
    return Evidence(heatmap_from_boxes(visible, *size), found, unknown_words)


def nothing(size: tuple[int, int], unknown_words: tuple[str, ...]) -> Evidence:
    """Return the evidence for a phrase that the model cannot read: it looked for nothing."""
    return Evidence(np.zeros((size[1], size[0]), dtype=np.float32), (), unknown_words)
