"""What people say beside the matter, behind the name of a thing: no part of the name."""

from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.things import names

ASIDE_SHARE = 0.07
BARE_SHARE = 0.25
"""How often without commas, as a speech recogniser writes it"""
ASIDES = names(
    """
clear of the lead | clear of the wires | you know | you know, the upper one | the upper one | the
red one I mean | I mean the big one | the one we had before | mind the cable | well away from the
glass | if you see it | where it is dry | not too hard | careful | flat | it wobbles a bit | as
always | you see it | the old one | not the new one | without knocking it over | please be careful |
I think | if that is what it's called | or whatever it's called | that's the one | you can't miss
it | for now | it's sturdy | it's hot | no hurry | easy does it | clean side only | as I said | same
as yesterday | the nice one | the one on the left | my favourite | thank you | it won't break | so
you don't slip | so I can get past | out of the way | out of the light | short of the mark | if I
may say so | just there | don't spill anything | gently | with some care | the real one
""",
    "|",
)


def with_aside(template: str, draw: Draw) -> str:
    """Return a template with an aside behind the last thing that it names, now and then."""
    at = template.rfind("}") + 1
    if not at or template[at : at + 1] not in ("", " ") or not draw.chance(ASIDE_SHARE):
        return template
    comma = "" if draw.chance(BARE_SHARE) else ","
    rest = template[at:]
    return f"{template[:at]}{comma} {draw.pick(ASIDES)}{comma if rest else ''}{rest}"
