"""What a thing looks like when it is made of something else than usual."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.shape import Part, Shape, Texture


@dataclass(frozen=True)
class Finish:
    """The look of a material. It multiplies the object's colour."""

    texture: Callable[[np.random.Generator], Texture] | None
    gloss: float
    adjective: str
    """As in `the wooden handle`"""
    opacity: float = 1.0


FINISHES: dict[str, Finish] = {
    "wood": Finish(lambda rng: textures.wood(rng, 256, 256, 2), 0.25, "wooden"),
    "metal": Finish(textures.brushed, 1.0, "metal"),
    "plastic": Finish(None, 0.55, "plastic"),
    "ceramic": Finish(lambda rng: textures.speckle(rng, 0.012), 0.85, "ceramic"),
    "glass": Finish(None, 1.0, "glass", 0.5),
    "stone": Finish(textures.concrete, 0.2, "stone"),
    "cardboard": Finish(textures.cardboard, 0.05, "cardboard"),
    "paper": Finish(lambda rng: textures.speckle(rng, 0.01), 0.05, "paper"),
    "leather": Finish(textures.leather, 0.4, "leather"),
    "cotton": Finish(textures.weave, 0.02, "cotton"),
    "wool": Finish(lambda rng: textures.stripes(rng, 24), 0.0, "woollen"),
    "rubber": Finish(lambda rng: textures.speckle(rng, 0.02), 0.1, "rubber"),
    "wicker": Finish(textures.wicker, 0.1, "wicker"),
    "fabric": Finish(textures.weave, 0.02, "fabric"),
}
"""By the name a person says; `stoneware`, `porcelain` and the like are left to synonyms."""


def adjective(material: str) -> str:
    """Return the word before the noun: wooden for wood."""
    return FINISHES[material].adjective


PRINTED = frozenset({"cover", "front", "label", "print"})
"""Parts whose print says what the thing is: it stays, whatever the thing is made of"""
PRINTED_ON = frozenset({"cover"})
"""Of these, what is printed on the very thing and not on paper that is glued to it"""


def finished(shape: Shape, material: str, rng: np.random.Generator) -> Shape:
    """Return the shape with what is painted in the object's own colour made of `material`."""
    finish = FINISHES[material]
    texture = None if finish.texture is None else finish.texture(rng)
    return replace(
        shape, parts=tuple(_finished_part(part, finish, texture) for part in shape.parts)
    )


def _finished_part(part: Part, finish: Finish, texture: Texture | None) -> Part:
    if part.surface.paint != "main":
        return part
    if part.name in PRINTED_ON and part.surface.texture is not None and texture is not None:
        return replace(
            part, surface=replace(part.surface, texture=printed(part.surface.texture, texture))
        )
    if part.name in PRINTED:
        return part
    return replace(
        part,
        surface=replace(part.surface, texture=texture, gloss=finish.gloss, opacity=finish.opacity),
    )


def printed(ink: Texture, ground: Texture) -> Texture:
    """Return a texture (h, w, 3) printed on another one, in the size of the first."""
    height, width = ink.shape[:2]
    grounded = cv2.resize(ground, (width, height), interpolation=cv2.INTER_AREA)
    return cv2.multiply(ink, grounded, scale=1.0 / 255.0).astype(np.uint8)
