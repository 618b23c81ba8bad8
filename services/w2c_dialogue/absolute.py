"""Absolute prediction: the place is on an object.

Paper, Methods, "Absolute Positions": the maximum of the object's heatmap.
"""

from collections.abc import Callable

from w2c.errors import RefusedError
from w2c.messages import PhraseEvidence
from w2c_dialogue.advice.pointing import Pointed
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.on_top import upper_point
from w2c_dialogue.prompts.base import SceneObject
from w2c_dialogue.sight import Prediction, unknown_warnings

Choose = Callable[[PhraseEvidence], Pointed]
"""Another rule for the point on a thing that is seen"""


def predict(
    seen: PhraseEvidence, frame: Frame, choose: Choose | None = None, *, on_top: bool = False
) -> Prediction:
    """Return where to touch the object.

    Args:
        seen: What grounding sees of it.
        frame: The picture.
        choose: Chooses the point; None: grounding's own.
        on_top: The words put it on top of the object; without `choose` the point is above the
            middle of what is seen of it.

    Raises:
        RefusedError: there is no point on it.
    """
    if seen.point is None:
        raise RefusedError(f"I see '{seen.phrase}' but no point on it; point at it with a click.")
    pointed = choose(seen) if choose else Pointed(None)
    upper = upper_point(seen, (frame.width, frame.height)) if on_top else None
    u, v = pointed.pixel or upper or seen.point
    if not (0 <= u <= frame.width and 0 <= v <= frame.height):
        raise RefusedError(
            f"'{seen.phrase}' was found at ({u:.0f}, {v:.0f}), outside the picture; point at it."
        )
    objects = (SceneObject(seen.phrase, seen.boxes[0]),) if seen.boxes else ()
    warnings = unknown_warnings([seen]) + ((pointed.warning,) if pointed.warning else ())
    return Prediction(u, v, objects, warnings)
