"""Clauses that say which thing is meant, as in "the chair my dad sits in": where they may not end.

Only words of closed classes are known here: pronouns, articles, prepositions, conjunctions.
"""

from collections.abc import Sequence

_ANYTHING = frozenset({"item", "object", "something", "thing"})
_SUBJECTS = frozenset(
    {"everybody", "everyone", "he", "i", "people", "she", "somebody", "someone", "they", "we",
     "you"}
)  # fmt: skip
_OWNERS = frozenset({"her", "his", "my", "our", "the", "their", "your"})
"""After a noun they begin the subject of a clause: `thing the vicar reads from`"""
_RELATIVE = frozenset({"that", "where", "which", "who"})
_PREPOSITIONS = frozenset({"at", "from", "in", "off", "on", "through", "to", "under", "with"})
"""Those that a clause about a thing may end with"""
_JOINS = frozenset(
    {"above", "against", "all", "and", "at", "behind", "below", "beside", "between", "by", "for",
     "from", "in", "into", "near", "of", "off", "on", "onto", "or", "over", "through", "to",
     "under", "with"}
)  # fmt: skip
"""An article after one of these belongs to it, and begins no clause"""
_GOES_ON = frozenset({"and", "by", "for", "if", "please", "then", "using", "with"})
"""What goes on with a sentence where a name has ended"""
_AMOUNTS = frozenset({"bit", "little", "lot", "tad", "touch"})
_POSTURES = frozenset({"hanging", "leaning", "lying", "resting", "sitting", "standing"})
_BESIDE = frozenset({"next", "on", "inside", "outside", "underneath"})
_MOST_OF_A_VERB = 2
"""Words: `normally carries`"""
_NO_VERB = frozenset(
    {
        "a", "an", "back", "down", "every", "his", "left", "me", "my", "our", "right", "that",
        "the", "their", "this", "up", "us", "where", "you", "your",
    }
)  # fmt: skip
"""After `to` they begin a direction, as in `move the thing to the left`"""


def is_cut(heard: Sequence[str], first: int, last: int) -> bool:
    """Tell whether a name that ends there ends within a clause about the thing.

    Args:
        heard: Words in lower case, with a comma wherever somebody pauses.
        first: Index of the first word of the name.
        last: Index of its last word.
    """
    return (
        _cut_short(heard, first, last)
        or _without_object(heard, first, last)
        or _stranded(heard, first, last)
        or _stands(heard, first, last)
    )


def _cut_short(heard: Sequence[str], first: int, last: int) -> bool:
    """Tell whether a name that ends there lacks what says which is meant: `thing | to wear`.

    Not so in `from the red thing to shelf two`, nor where a word before it says it, as in
    `the blue thing you see`.
    """
    if heard[last] in _RELATIVE:
        return True
    after = _after(heard, last)
    if heard[last] not in _ANYTHING or len(after) < 2:
        return False
    use = after[0] == "to" and after[1] not in _NO_VERB and "from" not in heard[:last]
    return use or (first == last and after[0] in _RELATIVE | _SUBJECTS | _OWNERS)


def _without_object(heard: Sequence[str], first: int, last: int) -> bool:
    """Tell whether a clause ends before what its verb does it to: `thing that opens | the door`."""
    if heard[last].endswith(",") or last + 1 == len(heard):
        return False
    begins = _RELATIVE - {"where"}
    verb = any(heard[at] in begins for at in range(max(first + 1, last - _MOST_OF_A_VERB), last))
    after = _after(heard, last)
    return verb and after[0] in _OWNERS | {"a", "an"} and _AMOUNTS.isdisjoint(after)


def _stands(heard: Sequence[str], first: int, last: int) -> bool:
    """Tell whether a name ends before where the thing is: `radio that is lying | on a bed`."""
    after = _after(heard, last)
    return (
        first < last and heard[last] in _POSTURES and bool(after) and after[0] in _JOINS | _BESIDE
    )


def _stranded(heard: Sequence[str], first: int, last: int) -> bool:
    """Tell whether the preposition of a clause is left behind: `thing to dig | with`.

    Not so where it begins something else, as in `take the thing to dig with your right hand`.
    """
    if _has_subject(heard, first, last):
        end = last + 1
        while end < len(heard) and _in_one_phrase(heard[end - 1], heard[end]):
            end += 1
        return _ends_a_clause(heard, end)
    return not _ANYTHING.isdisjoint(heard[first:last]) and _ends_a_clause(heard, last + 1)


def _after(heard: Sequence[str], at: int) -> list[str]:
    """Return the next two words, or as many as there are, without the pauses behind them."""
    return [word.rstrip(",") for word in heard[at + 1 : at + 3]]


def _in_one_phrase(word: str, following: str) -> bool:
    return not word.endswith(",") and following.rstrip(",") not in _JOINS | _OWNERS | _SUBJECTS


def _ends_a_clause(heard: Sequence[str], at: int) -> bool:
    """Tell whether a preposition stands there with nothing that belongs to it."""
    return (
        at < len(heard)
        and not heard[at - 1].endswith(",")
        and heard[at].rstrip(",") in _PREPOSITIONS
        and (at + 1 == len(heard) or heard[at].endswith(",") or _after(heard, at)[0] in _GOES_ON)
    )


def _has_subject(heard: Sequence[str], first: int, last: int) -> bool:
    """Tell whether a name has a clause with a subject of its own: `chair | my dad sits`."""
    return any(
        heard[at] in _SUBJECTS or (heard[at] in _OWNERS and heard[at - 1] not in _JOINS)
        for at in range(first + 1, last + 1)
    )
