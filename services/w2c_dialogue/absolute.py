"""Absolute prediction: the place is on an object.

Paper, Methods, "Absolute Positions": the maximum of the object's heatmap.
"""

from w2c.errors import RefusedError
from w2c_dialogue.interfaces import Frame, Grounding
from w2c_dialogue.prompts.base import SceneObject
from w2c_dialogue.sight import Prediction, look, twin_warnings
from w2c_dialogue.utterance import Mention


def predict(grounding: Grounding, frame: Frame, mention: Mention) -> Prediction:
    """Return where to touch the object. Raises RefusedError where it is not seen, CallError."""
    seen = look(grounding, frame, [mention], "heatmaps")[0]
    if seen.point is None:
        raise RefusedError(f"I see '{seen.phrase}' but no point on it; point at it with a click.")
    u, v = seen.point
    if not (0 <= u <= frame.width and 0 <= v <= frame.height):
        raise RefusedError(
            f"'{seen.phrase}' was found at ({u:.0f}, {v:.0f}), outside the picture; say it again."
        )
    objects = (SceneObject(seen.phrase, seen.boxes[0]),) if seen.boxes else ()
    return Prediction(u, v, objects, twin_warnings([seen]))
