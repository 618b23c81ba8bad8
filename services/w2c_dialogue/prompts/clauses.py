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
_NO_VERB = frozenset(
    {
        "a", "an", "back", "down", "every", "his", "left", "me", "my", "our", "right", "that",
        "the", "their", "this", "up", "us", "where", "you", "your",
    }
)  # fmt: skip
"""After `to` they begin a direction, as in `move the thing to the left`"""


def cut_short(folded: Sequence[str], first: int, last: int) -> bool:
    """Tell whether a name that ends there lacks what says which is meant: `thing | to wear`.

    Not so in `from the red thing to shelf two`, nor where a word before it says it, as in
    `the blue thing you see`.

    Args:
        folded: In lower case, commas kept.
        first: Index of the first word of the name.
        last: Index of its last word.
    """
    if folded[last] in _RELATIVE:
        return True
    after = folded[last + 1 : last + 3]
    if folded[last] not in _ANYTHING or len(after) < 2:
        return False
    use = after[0] == "to" and after[1] not in _NO_VERB and "from" not in folded[:last]
    return use or (first == last and (after[0] in _RELATIVE or after[0] in _SUBJECTS))


def stranded(folded: Sequence[str], first: int, last: int) -> bool:
    """Tell whether the preposition of a clause is left behind: `thing to dig | with`.

    Not so where it begins something else, as in `take the thing to dig with your right hand`.

    Args:
        folded: In lower case, commas kept.
        first: Index of the first word of the name.
        last: Index of its last word.
    """
    if _has_subject(folded, first, last):
        end = last + 1
        while end < len(folded) and _in_one_phrase(folded[end - 1], folded[end]):
            end += 1
        return _ends_a_clause(folded, end)
    return not _ANYTHING.isdisjoint(folded[first:last]) and _ends_a_clause(folded, last + 1)


def _in_one_phrase(word: str, following: str) -> bool:
    return not word.endswith(",") and following.rstrip(",") not in _JOINS | _OWNERS | _SUBJECTS


def _ends_a_clause(folded: Sequence[str], at: int) -> bool:
    """Tell whether a preposition stands there with nothing that belongs to it."""
    return (
        at < len(folded)
        and not folded[at - 1].endswith(",")
        and folded[at].rstrip(",") in _PREPOSITIONS
        and (at + 1 == len(folded) or folded[at].endswith(",") or folded[at + 1] in _GOES_ON)
    )


def _has_subject(folded: Sequence[str], first: int, last: int) -> bool:
    """Tell whether a name has a clause with a subject of its own: `chair | my dad sits`."""
    return any(
        folded[at] in _SUBJECTS or (folded[at] in _OWNERS and folded[at - 1] not in _JOINS)
        for at in range(first + 1, last + 1)
    )
