"""What a person may call a thing so that nothing else in the picture could be meant."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from w2c_evaluation.benchmark.sight import Thing
from w2c_evaluation.benchmark.uses import ALSO_CALLED, USES

How = Literal["plain", "synonym", "colour", "material", "part", "use"]
ADJECTIVES = {"wood": "wooden", "wool": "woollen"}
SIZES = ("large", "small")
THE_THING = "thing with the "
CONTENTS = frozenset({"nails", "soap", "milk", "pencils"})
"""Names of what is inside: it has neither the colour nor the material of the thing"""
_CLOSE_COLOURS = frozenset(
    frozenset(pair)
    for pair in (
        ("red", "orange"), ("red", "pink"), ("red", "brown"), ("orange", "yellow"),
        ("orange", "brown"), ("blue", "turquoise"), ("green", "turquoise"), ("blue", "purple"),
        ("purple", "pink"), ("black", "grey"), ("grey", "white"), ("black", "brown"),
        ("brown", "yellow"),
    )
)  # fmt: skip
"""Colours that people draw different borders between"""
_CLOSE_MATERIALS = frozenset(
    frozenset(pair)
    for pair in (
        ("fabric", "cotton"), ("fabric", "wool"), ("cotton", "wool"), ("paper", "cardboard"),
        ("ceramic", "stone"), ("ceramic", "glass"), ("plastic", "rubber"), ("wood", "wicker"),
    )
)  # fmt: skip
"""Materials that look alike, or that are called by the same word"""


@dataclass(frozen=True)
class Naming:
    """Words for a thing, without article."""

    text: str
    how: How
    """plain: its usual name is among the words, with or without colour and the like"""
    attribute: str = ""
    """colour, size, material: what it needs to be told from another of its kind"""


def namings(thing: Thing, seen: Sequence[Thing]) -> list[Naming]:
    """Return what a thing may be called among those that are seen; nothing else could be meant."""
    others = [other for other in seen if other.name != thing.name]
    found = [*_named(thing, others), *_described(thing, others), *_of_use(thing, others)]
    return list({naming.text: naming for naming in found}.values())


def told_apart(a: Thing, b: Thing) -> bool:
    """Whether a colour, a material or a size tells two of a kind apart for everybody."""
    by_colour = not _close(a.colour, b.colour)
    by_material = bool(a.material) and _other_material(a, b)
    return by_colour or by_material or bool(_sizes(a)) or bool(_sizes(b))


def _named(thing: Thing, others: Sequence[Thing]) -> Iterator[Naming]:
    """Yield its names, with what they need to fit nothing else."""
    adjective = _adjective(thing)
    for number, name in enumerate(thing.names):
        how: How = "plain" if number == 0 or _holds(name, thing.names[0]) else "synonym"
        alike = [other for other in others if _may_be_called(other, name)]
        twins = any(other.kind == thing.kind for other in alike)
        if not alike:
            yield Naming(name, how)
        if name in CONTENTS:
            continue
        if all(not _close(thing.colour, other.colour) for other in alike):
            yield Naming(f"{thing.colour} {name}", how, "colour" if twins else "")
        if adjective and all(_other_material(thing, other) for other in alike):
            yield Naming(f"{adjective} {name}", how, "material" if twins else "")
        if all(other.kind == thing.kind for other in alike):
            for size in _sizes(thing):
                yield Naming(f"{size} {name}", how, "size" if twins else "")


def _described(thing: Thing, others: Sequence[Thing]) -> Iterator[Naming]:
    """Yield `red thing`, `wooden thing`, `thing with the wooden handle`."""
    twin = any(other.kind == thing.kind for other in others)
    if all(not _close(thing.colour, other.colour) for other in others):
        yield Naming(f"{thing.colour} thing", "colour", "colour" if twin else "")
    adjective = _adjective(thing)
    if adjective and all(_other_material(thing, other) for other in others):
        yield Naming(f"{adjective} thing", "material", "material" if twin else "")
    for phrase in thing.own_phrases:
        if phrase.startswith(THE_THING):
            yield Naming(phrase, "part", "material" if twin else "")


def _of_use(thing: Thing, others: Sequence[Thing]) -> Iterator[Naming]:
    texts, kinds = USES.get(thing.kind, ((), ()))
    if not any(other.kind in kinds for other in others):
        for text in texts:
            yield Naming(text, "use")


def _may_be_called(other: Thing, name: str) -> bool:
    """Whether somebody could call another thing by a name: its head noun decides."""
    head = _head(name)
    heads = {_head(known) for known in other.names}
    return head in heads or name in other.names or other.kind in ALSO_CALLED.get(head, ())


def _head(name: str) -> str:
    """Return the noun of a name: `box` of `box of nails` and of `cereal box`."""
    return name.partition(" of ")[0].split()[-1]


def _holds(name: str, usual: str) -> bool:
    """Whether a name has all words of the usual one: `claw hammer`, `box of nails`."""
    return set(usual.split()) <= set(name.split())


def _sizes(thing: Thing) -> list[str]:
    """Return `large` or `small` where others of its kind in the scene are of another size."""
    return [size for size in SIZES if f"{size} {thing.names[0]}" in thing.phrases]


def _other_material(thing: Thing, other: Thing) -> bool:
    """Whether nobody would say the material of a thing of another one."""
    pair = frozenset((thing.material, other.material))
    if not other.material or len(pair) < 2 or pair in _CLOSE_MATERIALS:
        return False
    # Of another material that does not show, the truth says both.
    return f"{_adjective(thing)} {other.names[0]}" not in other.phrases


def _adjective(thing: Thing) -> str:
    """Return what is said before its name for what it is made of; empty where nobody says it."""
    return ADJECTIVES.get(thing.material, thing.material)


def _close(a: str, b: str) -> bool:
    return a == b or frozenset((a, b)) in _CLOSE_COLOURS
