"""The words of corrections that are to be followed to the letter (`exact_moves`)."""

from w2c_dialogue.corpus.things import meanings, names

EACH = names(
    """
{1} by {0} each | {0} {1} | {1}, {0} each | {1} by {0} | {1}, both by {0} | {0} each {1} | {1}, the
same distance both ways, {0} | {0} in both directions, {1} | {1}, {0} both ways
""",
    "|",
)
"""A length and two directions"""
TOWARDS = names("""
towards, toward, closer to, nearer to, nearer, in the direction of, to the side of, closer in to,
over towards
""")
OFF = names("""
away from, further away from, farther from, further from, back from, off from, off, clear of, out
from
""")
BACK_OR_ON = tuple(
    (f"{lead} {text}".strip(), sign)
    for text, sign in (
        *((f"{way} {{}}", "-") for way in names("back, come back, go back, back by, go back by")),
        *((f"{way} {{}}", "-") for way in names("return by, come back about, take back, undo")),
        *((f"{{}} {way}", "-") for way in names("back, back again, too far, too much, past it")),
        *((f"{way} by {{}}", "-") for way in names("too far, overshot, went too far, too much")),
        ("that was {} too far", "-"),
        ("it went {} too far", "-"),
        ("{} less than that", "-"),
        ("not so far, {} less", "-"),
        ("you can take {} off again", "-"),
        *((f"{{}} {way}", "+") for way in names("more, more of that, further, extra")),
        *((f"{{}} {way}", "+") for way in names("more the same way, more in that direction")),
        *((f"{way} {{}}", "+") for way in names("another, one more time, only, add, and again")),
        *((f"{way} {{}} more", "+") for way in names("about, go on, go, it needs, continue for")),
        ("keep going for {}", "+"),
        ("go on for {}", "+"),
        ("same direction, {}", "+"),
        ("{} further the same way", "+"),
        ("not enough, {} more", "+"),
        ("it still misses {}", "+"),
        ("short by {}", "+"),
        ("still {} short", "+"),
    )
    for lead in ("", "", "ok", "no,")
)
"""A length and whether it goes on the way of the last move, or back"""
EARLIER = meanings("""
+first: the first move again, same as the first move, repeat the first move, do the first one again,
the first correction once more, same as the first move one more time, again what you did first, the
first one again, like the first move, repeat the very first correction, the same as your first move
| -first: undo the first move, take the first one back, undo the first correction, cancel the first
move, reverse the first move, without the first move, take back only the first move | +moves[-2]:
the move before last again, repeat the second last move, the one before last again, same as the move
before the last one, do the second to last one again, like the move before, again the one before
that, the last but one again, same as two moves ago | -moves[-2]: undo the move before last, take
back the second last move, undo the one before last, cancel the move before the last one, keep the
last move but undo the one before, reverse the second to last move
""")
"""A move that is not the last, and what becomes of it"""
AXIS_NAMES = {
    "u": names("u, u, x, x, the u axis, the x axis, horizontal"),
    "v": names("v, v, y, y, the v axis, the y axis, vertical"),
}
SIGNED = (
    *(
        (template, "+")
        for template in names("""
{1} plus {0}, {1} +{0}, +{0} in {1}, plus {0} in {1}, {1} by +{0}, add {0} to {1}, increase {1} by
{0}, {0} in positive {1}, {0} along {1}, {1} by {0}, {0} more in {1}
""")
    ),
    *(
        (template, "-")
        for template in names("""
{1} minus {0}, {1} -{0}, -{0} in {1}, minus {0} in {1}, {1} by -{0}, subtract {0} from {1}, decrease
{1} by {0}, {0} in negative {1}, minus {0} along {1}, {1} by minus {0}, {0} less in {1}, take {0}
off {1}, reduce {1} by {0}
""")
    ),
)
"""A number and an axis; `v up by 10` is left out, for v grows downwards"""
