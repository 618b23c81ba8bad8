"""Which words of an utterance may name a thing, as the schema of an answer.

A small model that has not met a phrasing names words around a thing with it ("and the mug"), or
words that name nothing ("a bit further"), and then the thing is looked for in vain. Words of closed
classes rule most of that out: no name begins with "and" or ends with "of", and directions, amounts
and parts alone name nothing. What may be a name is left to the model.
"""

from collections.abc import Sequence

from w2c_dialogue.prompts.clauses import is_cut
from w2c_dialogue.prompts.limb_words import LIMBS
from w2c_dialogue.utterance import LETTERS, Span, Utterance

MAX_SPAN_WORDS = 12
MAX_ENUM = 256
"""Longer lists are refused by the language service."""

_JOINING = frozenset(
    {
        "and", "as", "be", "but", "by", "for", "i", "if", "into", "my", "nor", "of", "onto", "or",
        "our", "please", "so", "than", "the", "then", "to", "was", "we", "your",
    }
)  # fmt: skip
_ASIDES = frozenset(
    {
        "aye", "believe", "dear", "er", "hm", "no", "ok", "okay", "thanks", "think", "uh", "um",
        "yes",
    }
)  # fmt: skip
NEVER_LAST = (_JOINING | _ASIDES | {"an", "further", "here", "lean", "more", "put"}) - {"to"}
"""No name ends with them. "The thing that we cook with" ends with a preposition"""
NEVER_FIRST = (
    _JOINING
    | _ASIDES
    | {
        "a", "an", "are", "at", "down", "from", "further", "go", "here", "in", "is", "it", "it's",
        "its", "lean", "me", "more", "not", "on", "put", "there", "up", "us", "with", "you",
    }
) - {"my", "our"}  # fmt: skip
"""No name begins with them; the model is trained to leave articles out"""
NO_NAMES = (
    NEVER_FIRST
    | NEVER_LAST
    | {
        "again", "back", "bit", "bottom", "breadth", "center", "centimeters", "centimetres",
        "centre", "closer", "cm", "corner", "direction", "double", "downward", "downwards", "edge",
        "far", "farther", "finger", "finger's", "fingers", "fist", "foot", "front", "half", "hand",
        "hand's", "hands", "higher", "inch", "inches", "left", "leftward", "leftwards", "little",
        "lot", "lower", "middle", "much", "near", "nearer", "other", "palm", "palms", "right",
        "rightward", "rightwards", "same", "side", "sides", "slightly", "sole", "soles", "tad",
        "that", "this", "thumb", "thumb's", "top", "touch", "twice", "upward", "upwards", "way",
        "width",
    }
)  # fmt: skip
"""No name is made of these alone: directions, amounts, parts of a thing, and all of the above"""


def spans_schema(utterance: Utterance) -> dict[str, object]:
    """Return the schema of a list of spans; of a long utterance, of their ends only."""
    spans = naming_spans(utterance)
    if not spans:
        items: dict[str, object] = {"type": "string", "enum": ["0-0"]}
        return {"type": "array", "items": items, "minItems": 0, "maxItems": 0}
    items = {"type": "string", "enum": [str(span) for span in spans]}
    if len(spans) > MAX_ENUM:
        firsts, lasts = (_any_of({span[end] for span in spans}) for end in (0, 1))
        items = {"type": "string", "pattern": f"^({firsts})-({lasts})$"}
    return {"type": "array", "items": items, "minItems": 0, "maxItems": len(LETTERS)}


_MARKS = frozenset(".;:!?")
_CLOSING = "\"')]"
_OUT_OF = ["out", "of"]
"""`thing to drink out of`"""
_ANYTHING = frozenset({"object", "one", "something", "stuff", "thing", "things", "tool"})
"""`the thing to` goes on: it is told by what it is for"""
_OWN = frozenset({"my", "your"})
_SIDES = frozenset({"left", "right"})
_PLACES = frozenset(
    {
        "above", "at", "behind", "below", "beside", "between", "but", "in", "near", "next", "not",
        "on", "to", "under", "with",
    }
)  # fmt: skip
"""After a comma they begin something else"""

_AFTER_A_NAME = _PLACES | {"from", "please", "using"}
_VERBS_OF_IT = frozenset({"can", "will", "would"})


def naming_spans(utterance: Utterance) -> list[Span]:
    """Return the spans that may name a thing, in order."""
    words = [word.rstrip(",") for word in utterance.folded]
    heard = _with_pauses(utterance)
    return [
        Span(first + 1, last + 1)
        for first in range(len(words))
        for last in range(first, min(first + MAX_SPAN_WORDS, len(words)))
        if words[first] not in NEVER_FIRST
        and (words[last] not in NEVER_LAST or words[first + 1 : last + 1][-2:] == _OUT_OF)
        and not NO_NAMES.issuperset(words[first : last + 1])
        and not is_cut(heard, first, last)
        and not _goes_past(heard, first, last)
        and not _stops_short(words, last)
        and not _parts_it_from_a_noun(heard, last)
        and not _takes_of_a_limb(words, first, last)
    ]


def _with_pauses(utterance: Utterance) -> list[str]:
    """Return the words in lower case, with a comma wherever a mark is typed behind one."""
    return [
        f"{word.rstrip(',')}," if typed.rstrip(_CLOSING)[-1:] in _MARKS else word
        for word, typed in zip(utterance.folded, utterance.typed, strict=True)
    ]


def _goes_past(heard: Sequence[str], first: int, last: int) -> bool:
    """Tell whether a name goes past its end: `step, | behind the milk bottles`."""
    return any(heard[at].endswith(",") and heard[at + 1] in _PLACES for at in range(first, last))


def _stops_short(words: Sequence[str], last: int) -> bool:
    """Tell whether a name ends before what a thing is for: `the thing to | hit with`."""
    return words[last] == "to" and words[last - 1] in _ANYTHING and last + 1 < len(words)


def _parts_it_from_a_noun(heard: Sequence[str], last: int) -> bool:
    """Tell whether a name ends before, or at, an `it` that is no pronoun: `cheez | it box`.

    A pronoun has no noun behind it with which the sentence, or its part, ends. What ends with an s
    may be its verb: `on the shelf it goes`.
    """
    it = last if heard[last] == "it" else last + 1
    noun = it + 1
    if noun >= len(heard) or heard[it] != "it":
        return False
    if heard[it - 1].endswith(",") or heard[it - 1] in _PLACES:
        return False
    ends = noun + 1 == len(heard) or heard[noun].endswith(",") or heard[noun + 1] in _AFTER_A_NAME
    word = heard[noun].rstrip(",")
    return ends and not word.endswith("s") and word not in NO_NAMES | _PLACES | _VERBS_OF_IT


def _takes_of_a_limb(words: Sequence[str], first: int, last: int) -> bool:
    """Tell whether words of a limb are in a name: `the thing to wear | with your left hand`.

    A limb without its side may be: `the tap you work with your foot`.
    """
    return any(
        words[at] in ("using", "with")
        and not _OWN.isdisjoint(words[at + 1 : at + 2])
        and not _SIDES.isdisjoint(words[at + 2 : at + 3])
        and not LIMBS.isdisjoint(words[at + 3 : at + 4])
        for at in range(first, last + 1)
    )


def _any_of(numbers: set[int]) -> str:
    """Return a short regular expression of whole numbers below 100."""
    groups: dict[int, str] = {}
    for number in sorted(numbers):
        groups[number // 10] = groups.get(number // 10, "") + str(number % 10)
    return "|".join(f"{tens or ''}[{ones}]" for tens, ones in groups.items())
