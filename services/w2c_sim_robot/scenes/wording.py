"""Phrases that fit a thing in its scene, and those that fit no other thing there."""

from collections.abc import Sequence

import numpy as np

from w2c_sim_robot.scenes.objects.catalogue import shape_of
from w2c_sim_robot.scenes.objects.looks import lookalikes, tells_apart
from w2c_sim_robot.scenes.objects.materials import FINISHES, adjective
from w2c_sim_robot.scenes.objects.shape import Size
from w2c_sim_robot.scenes.scene import SceneObject

OTHER_SIZE_RATIO = 1.25
"""From here on people see that two of a kind differ in size"""
CONTENTS = frozenset({"nails", "soap", "milk", "pencils"})
"""Names of what is inside: it is not of the material of the thing, nor of its size"""


def length_of(size: Size) -> float:
    """Return the edge of a cube of the same volume [m]."""
    return float(np.cbrt(size[0] * size[1] * size[2]))


def of_other_size(one: Size, other: Size) -> bool:
    """Return whether people see that two of a kind differ in size."""
    ratio = length_of(one) / length_of(other)
    return max(ratio, 1.0 / ratio) >= OTHER_SIZE_RATIO


def parts_of(item: SceneObject) -> tuple[str, ...]:
    """Return the names of its parts, each once."""
    return tuple(dict.fromkeys(part.name for part in shape_of(item).parts if part.name))


def phrases_in(item: SceneObject, scene: Sequence[SceneObject]) -> tuple[str, ...]:
    """Return every phrase that fits a thing among those of its scene.

    Names; each with colour, material, or both; `large` and `small` among others of its kind; and a
    part of another material, as in `the thing with the wooden handle`. Where two of a kind look
    alike but are of other materials, what is said of the one fits the other.
    """
    phrases = list(item.phrases())
    names = [name for name in item.names if name not in CONTENTS]
    for word in _material_words(item, scene):
        for name in names:
            phrases += [f"{word} {name}", f"{item.colour} {word} {name}"]
    size = size_word(item, scene)
    if size:
        for name in names:
            phrases += [f"{size} {name}", f"{size} {item.colour} {name}"]
    for part in shape_of(item).parts:
        if part.name and part.material in FINISHES:
            phrases.append(f"thing with the {adjective(part.material)} {part.name}")
    return tuple(dict.fromkeys(phrases))


def doubtful_words(item: SceneObject) -> tuple[str, ...]:
    """Return what is said of materials that it is not of, but might be, as far as people see."""
    others = lookalikes(item.kind, item.material, item.colour)
    return tuple(dict.fromkeys(word for one in others for word in (one, adjective(one))))


def _material_words(item: SceneObject, scene: Sequence[SceneObject]) -> list[str]:
    """Return what it may be said to be made of, its own material first."""
    alike = [o.material for o in scene if o.kind == item.kind and not _materials_differ(item, o)]
    return [adjective(one) for one in dict.fromkeys([item.material, *alike]) if one in FINISHES]


def _materials_differ(a: SceneObject, b: SceneObject) -> bool:
    """Whether people see that two of a kind are of other materials."""
    return tells_apart(a.kind, a.material, b.material, a.colour, b.colour)


def size_word(item: SceneObject, scene: Sequence[SceneObject]) -> str:
    """Return `large` or `small` where others of its kind are clearly smaller or larger."""
    others = [length_of(o.size) for o in scene if o.kind == item.kind and o.name != item.name]
    if not others:
        return ""
    own = length_of(item.size)
    if own > OTHER_SIZE_RATIO * max(others):
        return "large"
    return "small" if own * OTHER_SIZE_RATIO < min(others) else ""


def told_apart_by(a: SceneObject, b: SceneObject) -> str:
    """Return the attribute that tells two of a kind apart: colour, size, material, or nothing."""
    if a.colour != b.colour:
        return "colour"
    if of_other_size(a.size, b.size):
        return "size"
    return "material" if _materials_differ(a, b) else ""
