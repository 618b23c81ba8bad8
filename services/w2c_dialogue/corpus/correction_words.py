"""The words of corrections.

In `meanings("1: x, y | 2: z")` the words x and y mean 1, and z means 2.
"""

from w2c_dialogue.corpus.things import meanings, names

TINY = names("""
a tiny bit, a hair, a touch, a smidge, just a tad, a tad, very slightly, a teeny bit, ever so
slightly, a notch, one notch, barely, just barely, marginally, fractionally, a whisker, a fraction,
the tiniest bit, a tiny little bit, minimally, a smidgen, a hair's breadth, a very small bit
""")
SMALL = names("""
a bit, a bit, a bit, a bit, a bit, a little, a little, a little bit, slightly, slightly, somewhat,
just a bit, just a little, a bit more, a little more, a small step, a small amount, a little bit
more, a bit further, a little further, a small bit, a little way, a bit farther, just slightly
""")
PLAIN = ("", "", "", "", "more", "further", "some more", "a step", "again", "one step", "farther")
LARGE = names("""
a lot, a lot more, much, much more, way, far, a great deal, much further, way more, considerably,
a big step, a good deal, significantly, way further, quite a lot, a whole lot, a lot, quite a bit, a
good bit, loads, heaps, tons, miles, substantially, drastically, massively, a huge step, a big chunk
""")
STEPS = ((0.08, ("10", TINY)), (0.32, ("20", SMALL)), (0.15, ("100", LARGE)))
"""How often; pixels and words"""
STEP = ("40", PLAIN)
"""The same of the rest"""
TO = {
    "left": names("""
left, to the left, to the left, leftwards, leftward, to your left, towards the left, on the left,
to left, left side, toward the left, to the left side
"""),
    "right": names("""
right, to the right, to the right, rightwards, rightward, to your right, towards the right, on the
right, to right, right side, toward the right, to the right side
"""),
    "up": names("""
up, upwards, higher, up, to the top, towards the top, further away, away from you, farther away,
upward, further back, higher up, deeper, to the back, forward, forwards, ahead, towards the back
"""),
    "down": names("""
down, downwards, lower, down, to the bottom, towards the bottom, closer to you, nearer, towards
you, downward, closer to yourself, lower down, towards the robot, to the front, backwards,
backward, towards the front, closer to the robot
"""),
}
TWO_LINKS = (
    " and ",
    " and ",
    ", ",
    " and then ",
    ", then ",
    ", and ",
    " but only ",
    ", and just ",
    " plus ",
    " with ",
    " & ",
)
"""Between two directions of different amounts"""
MOVE = names("""
move, go, shift, slide, move it, shift it, slide it, move the target, move the point, move your
hand, push it, nudge it, bring it, put it, go, move the contact, move the dot, adjust it, place
it, take it, drag it, shift the point, move the marker, shift the target, move that, nudge, drag,
scoot, scooch it, displace it, relocate it, translate, correct it, move the goal, it should be, it
needs to be, should be, needs to go, I want it, make it, set it, the point should go, move the
hand, move your right hand, move your left hand, move the position
""")
MOVE_POINT = tuple(
    f"{verb} {what}"
    for verb in ("move", "shift", "slide", "drag", "nudge", "bring", "relocate", "push")
    for what in (
        "it",
        "it",
        "the target",
        "the point",
        "the dot",
        "the contact",
        "the marker",
        "that",
        "the contact point",
    )
)
"""Verbs that speak of the point on the screen: "put it on the cup" would be a new instruction."""
LEADS = names("""
no, no no, please, can you, could you, now, ok now, but, almost, not quite, nearly there, good
but, not there, hmm, wait, ok but, yes but, close but, almost there, a correction:, I'd say, now
please, and, then, still, no please, that's good but, just, almost perfect, good direction, so
close
""")
TAILS = names("""
please, now, thanks, again, ok, from there, from here, in the picture, in the image, on the image,
if possible, from where it is, instead, of where it is now, than that, carefully, robot, from this
point, would be better, thank you, would be perfect
""")
AGAIN_AS = {
    "1": names("""
again, more, same again, once more, the same again, one more time, do that again, keep going,
continue, further, some more, repeat that, another step, and again, go on, keep moving, do it
again, the same amount again, a step further, same thing again, further still, still more, not
enough, that's not enough, more please, one more, carry on, repeat, same direction, continue that
way
"""),
    "2": names("""
twice as much, twice as much as before, move twice as much, now move twice as much as before,
double that, twice that, two times that, do twice that, the same but double, twice the distance,
double the distance, now twice as far, twice as far, go twice as far as before, and now double it,
2 times more, move two times as much, twice as much again, twice that distance, do that twice,
double the last move, twice the last move
"""),
    "3": names("""
three times as much, three times that, triple that, three times as far, 3 times as much as before,
thrice that, move three times the distance
"""),
    "4": names("four times that, four times as much, quadruple that, 4 times as far"),
    "1.5": names("""
one and a half times that, 1.5 times as much, half as much again on top, one and a half times as far
"""),
    "0.33": names("a third of that, one third of that, a third as much, only a third of it"),
    "0.25": names("a quarter of that, a quarter as much, only a quarter of that, a fourth of that"),
    "0.5": names("""
half of that, half as much, half that, half as much as before, move half as much, only half of
that, half the distance, now half of it, a bit more of the same, half that again, half as far,
half of the last move, a bit more, a little more, a little further, slightly further, a bit
further, just a little more, a little bit further, a little bit more, half a step more
"""),
    "-0.5": names("""
too far, too much, that's too much, that was too far, you went too far, a bit less, less, a little
less, back by half, half way back, go back half, undo half of it, not so far, not that far, not
that much, that's a bit too much, a little back, go back a bit, go back a little, back a bit,
slightly too far, overshot, you overshot, it's too far, way too much, half back, not so much
"""),
    "-1": names(
        """
back, go back, undo, undo that, go back to where it was, undo the last move, cancel that, take
that back, back to the previous position, revert, revert that, previous position, move back, put
it back, back to where it was before, no go back, undo it, as before, like before, where it was
before, return to the previous point, the last one was better, it was better before, before was
better, back where you were, undo the last correction, step back, return
"""
    )
    + names(
        """
no, the other way | other way | wrong direction | wrong way | no, the opposite direction | the
opposite | that's the wrong direction | no the other direction | I meant the other way | the other
way please | not that way, the other way | the other way around | opposite, not that way | you
moved the wrong way | you went the wrong way | no, other side | wrong side | it went the wrong way
| no, the other side | no, in the opposite direction | no, wrong direction | the other way | not
this way, the other | the reverse | opposite direction | move in the opposite direction | the other
direction | in the other direction
""",
        "|",
    ),
}
"""How much of the last move is added. The other way is as far the other way"""
START = names("""
back to the start, go back to the beginning, the first position, back to the first point, undo
everything, undo all, reset, start over, back to the original position, the original point, where
it was at first, the very first one, go back to the initial position, return to the start, reset
the target, initial point, put it back where it was at the beginning, undo all corrections, forget
all corrections, the first one was better, back to square one, to where we started
""")
UNDO_TWO = names("""
undo the last two, undo twice, undo the last two moves, go back two steps, take back the last two,
two steps back, undo both, revert the last two corrections, back two moves, go back twice
""")
STAY = names("""
no, stop, wait, hold on, not yet, nope, cancel, no way, don't, don't move, no don't, that's wrong,
wrong, this is not right, not good, not there, not ok, no that's not it, I don't like it, bad, hmm
no, not like this, not correct, incorrect, nah, no good, don't do it, that is not what I want, not
sure, let me think, one moment, wait a second, abort, stop it, do nothing, no thanks, not really,
that's not right, it's not good yet, not perfect, not quite, that won't work, it isn't right,
absolutely not, never
""")
RESIZED = meanings("""
2: twice as much {}, {} twice as much, double that {}, twice as far {} | 0.5: half of that {}, {}
half as much, half as far {} | 1: the same amount {}, as much {}, {} by the same amount | 3: three
times as much {}
""")
"""A direction with the size of the last move, times a factor."""
CLOSER = meanings("""
closer A 0.4: closer to, closer to, nearer to, towards, toward, more towards, nearer, in the
direction of, closer in to, over towards, more in the direction of | closer A 0.5: halfway to,
halfway to, half way to, halfway towards, half the way to, midway to, half of the way to, halfway
between here and, half the distance to | towards A bit: a bit closer to, a little closer to, a bit
towards, slightly closer to, a bit nearer to, a bit nearer, slightly towards, a little nearer, a bit
more towards, a little towards | towards A tiny: a touch closer to, a tad closer to, a hair closer
to, a smidge nearer, just a tad towards, a tiny bit nearer to, a whisker closer to | closer A 0.25:
a quarter of the way to | closer A 0.7: much closer to, a lot closer to, much nearer, a lot nearer
to, way closer to, a good deal nearer | closer A 0.75: three quarters of the way to | closer A 0.8:
almost up to, nearly up to, almost all the way to | closer A 0.33: a third of the way to, a third of
the way towards, one third of the way to | closer A 0.67: two thirds of the way to, two thirds of
the way towards
""")
"""How far along the line to an object, as `moves` reads it"""
AWAY = meanings("""
off A step: away from, further away from, farther from, further from, away from, off, clear of | off
A bit: a bit away from, a bit further from, a little away from, less close to, slightly further
from, a bit off | off A tiny: a touch further from, a hair away from, a tad further off, a smidge
away from | off A lot: far away from, much further from, a lot further from, way off, well away from
""")
ONTO = names("""
onto, on, on top of, to the center of, to the middle of, to, in the middle of, to the centre of, all
the way to, right on, exactly on, over, up to
""")
EDGE_LEADS = names("to the, to the, on the, at the, onto the, towards the, up to the")
LEVEL = names("""
at the same height as, level with, to the height of, to the same level as, in line horizontally
with, align horizontally with, as high as
""")
IN_LINE = names("""
in line with, aligned with, lined up with, flush with, even with, on a line with, matching, so it
lines up with, align with, so it's in line with, so that it is level with
""")
"""With an edge, which tells along which axis"""
LEVEL_PARTS = meanings("""
a.top: top, top, upper edge, top edge, upper end | a.bottom: bottom, base, foot, lower edge, bottom
edge, lower end
""")
"""Parts of an object that something is level with"""
STRAIGHT = names("""
straight below, directly under, in line vertically with, align vertically with, straight above,
straight in front of, in the same column as
""")
COLUMN_PARTS = meanings("""
a.left: left edge, left side, left end | a.right: right edge, right side, right end
""")
"""Parts of an object that something is straight above or below"""
MEASURES = meanings("""
0.5*: half the, half a | : one, the, a | 2*: two, twice the | 0.25*: a quarter of the | 1.5*: one
and a half
""")
BETWEEN = names("between, in between, halfway between, midway between, in the middle of")
PIXELS = names(
    """
to pixel {} {} | to {}, {} | to {} {} | to x {} y {} | to ({}, {}) | to pixel {}, {} | to x={}
y={} | at {} {} | to the pixel {} {} | exactly at {}, {} | to coordinates {} {}
""",
    "|",
)
