"""A picture as a family keeps it, with the picture itself for those that look from near."""

from dataclasses import dataclass
from typing import Generic

from w2c_grounding.family import ContextT, Family, RgbImage
from w2c_grounding.second_look.crops import brought_to_width


@dataclass(frozen=True)
class SeenNear(Generic[ContextT]):
    """What the family keeps of a picture, and the picture."""

    context: ContextT
    image: RgbImage
    """Brought to the width of the training"""
    scale: float
    """Its pixels over those of the picture"""


def seen_near(family: Family[ContextT], image: RgbImage) -> SeenNear[ContextT]:
    """Return both; a family that looks from near itself has scaled the picture already."""
    context = family.prepare(image)
    if isinstance(context, SeenNear):
        return SeenNear(context, context.image, context.scale)
    return SeenNear(context, *brought_to_width(image))
