"""A place on a part of a thing ("on its left end") is on the thing, not in the corner of its box.

Arithmetic knows the box of a thing. Of what lies askew the box has corners that show something
else; there the nearest place that shows the thing is meant.
"""

from collections.abc import Sequence

from w2c.errors import CallError
from w2c_dialogue.expressions import ImagePoint
from w2c_dialogue.heat import hot, inner, nearest
from w2c_dialogue.interfaces import Frame, Grounding
from w2c_dialogue.prompts.base import SceneObject
from w2c_dialogue.sight import inside, within


def onto_thing(
    point: ImagePoint, objects: Sequence[SceneObject], grounding: Grounding, frame: Frame
) -> ImagePoint:
    """Return the place on the one thing that was named that is nearest to a point in its box.

    Every other point stays: outside the box, with several things, on the thing already, and where
    a silent model or one of boxes alone says nothing of the thing's outline.

    Args:
        point: In the picture [px].
        objects: The things that were named.
        grounding: Sees the outline of the thing.
        frame: The picture.
    """
    if len(objects) != 1 or not inside((point.u, point.v), objects[0].box):
        return point
    try:
        seen = grounding.ground(frame, [objects[0].phrase], "heatmaps")
    except CallError:
        return point
    if not seen or seen[0].heatmap is None:
        return point
    size = frame.width, frame.height
    # Another thing that fits the words may be lit, too.
    cells = inner(hot(within(seen[0].heatmap, objects[0].box, size)))
    return nearest(cells, point, size) or point
