"""What can be said of the objects of a picture, and of none of them."""

from collections import defaultdict
from collections.abc import Sequence
from typing import Literal

from w2c_grounding.train.data import SIZES, ObjectTruth, PictureTruth
from w2c_grounding.train.uses import fitting_kinds, is_use, possible_kinds, uses_of
from w2c_grounding.wording import words

# Colours that people draw different borders between: a "red" book is not asked to be no "orange"
# one.
_CLOSE_COLOURS = frozenset(
    frozenset(pair)
    for pair in (
        ("red", "orange"), ("red", "pink"), ("red", "brown"), ("orange", "yellow"),
        ("orange", "brown"), ("blue", "turquoise"), ("green", "turquoise"), ("blue", "purple"),
        ("purple", "pink"), ("black", "grey"), ("grey", "white"), ("black", "brown"),
    )
)  # fmt: skip

PhraseKind = Literal["name", "synonym", "colour", "material", "size", "part", "any", "use", "pair"]
"""How a phrase says which thing it means; `any` names no kind, as `the red thing` does, `use` says
what it is for, and `pair` tells one of two of a kind from the other by any of the attributes"""

PART_START = "thing with the "
NOUNS_OF_ANYTHING = ("thing", "object", "one")
COLOUR_WORDS = frozenset(
    {"red", "orange", "yellow", "green", "blue", "purple", "pink", "brown", "black", "grey"}
    | {"white", "turquoise"}
)


def fitting(truth: PictureTruth, phrase: str) -> tuple[int, ...]:
    """Return the ids of the objects that a bare phrase fits."""
    if is_use(phrase):
        kinds = fitting_kinds(phrase)
        return tuple(item.id for item in truth.objects if item.kind in kinds)
    spoken = words(phrase)
    if spoken[-1] in NOUNS_OF_ANYTHING and len(spoken) > 1:
        return tuple(
            item.id
            for item in truth.objects
            if all(word == item.colour or word in material_words(item) for word in spoken[:-1])
        )
    return tuple(item.id for item in truth.objects if phrase in item.phrases)


def kind_of(item: ObjectTruth, phrase: str) -> PhraseKind:
    """Return how a phrase of an object's own names it; never `any` or `pair`."""
    if phrase in item.names:
        return "name" if phrase == item.names[0] else "synonym"
    if phrase.startswith(PART_START):
        return "part"
    if phrase.startswith(SIZES):
        return "size"
    name = max((name for name in item.names if phrase.endswith(f" {name}")), key=len, default="")
    before = set(phrase.removesuffix(name).split())
    return "material" if before - {item.colour} else "colour"


def material_words(item: ObjectTruth) -> frozenset[str]:
    """Return what is said before its name for what it is made of: wood and wooden."""
    usual = f" {item.names[0]}"
    found = {
        phrase.removesuffix(usual)
        for phrase in item.phrases
        if phrase.endswith(usual) and phrase not in item.names
    }
    plain = {word for word in found if " " not in word}
    sizes = {size.strip() for size in SIZES}
    return frozenset(plain - sizes - COLOUR_WORDS - {item.colour}) if item.material else frozenset()


def phrases_by_kind(truth: PictureTruth, item: ObjectTruth) -> dict[PhraseKind, list[str]]:
    """Return all that can be said of an object in its picture."""
    found: dict[PhraseKind, list[str]] = defaultdict(list)
    for phrase in item.phrases:
        found[kind_of(item, phrase)].append(phrase)
    if any(other.kind == item.kind and other.id != item.id for other in truth.objects):
        attributes: tuple[PhraseKind, ...] = ("colour", "material", "size", "part")
        telling = [text for kind in attributes for text in found.get(kind, ())]
        own = [text for text in telling if fitting(truth, text) == (item.id,)]
        if own:
            found["pair"] = own
    # Where a neighbouring colour is in the picture, people would not agree.
    if not any(_close(item.colour, o.colour) and item.colour != o.colour for o in truth.objects):
        found["any"].append(f"{item.colour} thing")
    found["any"] += [f"{word} thing" for word in sorted(material_words(item))]
    found["use"] = [text for text in uses_of(item.kind) if _is_clear(truth, text)]
    return {kind: texts for kind, texts in found.items() if texts}


def _is_clear(truth: PictureTruth, use: str) -> bool:
    """Tell whether nothing in the picture only might be meant by a phrase of use."""
    doubtful = possible_kinds(use) - fitting_kinds(use)
    return not any(item.kind in doubtful for item in truth.objects)


def could_fit(truth: PictureTruth, phrase: str) -> bool:
    """Tell whether somebody could call an object in the picture this.

    Then it is no negative example. The head noun decides: a cereal box is a box too.
    """
    if is_use(phrase):
        kinds = possible_kinds(phrase)
        return any(item.kind in kinds for item in truth.objects)
    spoken = words(phrase)
    if phrase.startswith(PART_START):
        return any(_could_have_part(item, phrase) for item in truth.objects)
    head = spoken[-1]
    return any(
        _could_be(item, spoken[:-1])
        for item in truth.objects
        if head in NOUNS_OF_ANYTHING
        or any(words(name)[-1] == head or name == head for name in item.names)
    )


def _could_be(item: ObjectTruth, attributes: Sequence[str]) -> bool:
    """Tell whether nothing that is said of colour and material speaks against it."""
    colours = {word for word in attributes if word in COLOUR_WORDS}
    materials = {word for word in attributes if word in _KNOWN_MATERIALS}
    if colours and not any(_close(colour, item.colour) for colour in colours):
        return False
    return not materials or bool(materials & material_words(item)) or not item.material


def _could_have_part(item: ObjectTruth, phrase: str) -> bool:
    """Tell whether it has this part, of this material or of one that nobody said."""
    part = phrase.rsplit(" ", 1)[-1]
    if phrase in item.phrases:
        return True
    said = any(text.startswith(PART_START) and text.endswith(f" {part}") for text in item.phrases)
    return not said and any(other.name.endswith(part) for other in item.parts)


def _close(first: str, second: str) -> bool:
    return first == second or frozenset((first, second)) in _CLOSE_COLOURS


_KNOWN_MATERIALS = frozenset(
    {"wood", "wooden", "metal", "plastic", "ceramic", "glass", "stone", "cardboard", "paper"}
    | {"leather", "cotton", "wool", "woollen", "rubber", "wicker", "fabric"}
)
