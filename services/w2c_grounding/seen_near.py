"""A picture as a family keeps it, with the picture itself for those that look from near."""

from dataclasses import dataclass
from typing import Generic

from w2c_grounding.family import ContextT, Family, RgbImage
from w2c_grounding.second_look.crops import PICTURE_WIDTH, brought_to_width


@dataclass(frozen=True)
class SeenNear(Generic[ContextT]):
    """What the family keeps of a picture, and the picture."""

    context: ContextT
    image: RgbImage
    """Brought to a width"""
    scale: float
    """Its pixels over those of the picture"""


def seen_near(
    family: Family[ContextT], image: RgbImage, width: int = PICTURE_WIDTH
) -> SeenNear[ContextT]:
    """Return both, the picture `width` wide [px]: a family may have it already."""
    context = family.prepare(image)
    if isinstance(context, SeenNear) and context.image.shape[1] == width:
        small, scale = context.image, context.scale
    else:
        small, scale = brought_to_width(image, width)
    return SeenNear(context, small, scale)
