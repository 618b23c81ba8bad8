"""How people say yes to a point. Only a clear yes belongs here: it sets the robot in motion."""

from w2c_dialogue.corpus.draft import Draft
from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.things import names

YES = names("""
yes, yes please, yep, yeah, yup, sure, ok, okay, alright, correct, exactly, perfect, great, good,
fine, excellent, awesome, nice, cool, super, wonderful, brilliant, fantastic, lovely, that's it,
that's right, that's perfect, that's good, that's great, that's fine, that's correct, that is
perfect, that is good, that is right, that is it, this is perfect, this is good, this is it, this
is fine, this is right, it's perfect, it's good, it's fine, it is good, it is perfect, it looks
good, it looks perfect, looks good, looks great, looks perfect, looks right, looks fine, looks ok,
looks good to me, that looks good, that looks great, that looks right, that looks perfect, that
works, works for me, good for me, fine by me, fine with me, I like it, I'm happy, I'm happy with
that, I'm satisfied, I am satisfied with this, I agree, I confirm, confirm, confirmed, confirm it,
confirm the target, confirm that, confirm the position, approve, approved, accept, accepted, go,
go ahead, go for it, go there, do it, do that, just do it, ok do it, ok go, yes go, yes do it, yes
go ahead, please do, please go ahead, proceed, continue with it, execute, execute it, start, start
moving, begin, let's go, let's do it, let's do that, you can go, you may go, you can do it now,
you can move now, you can start, affirmative, roger, roger that, copy, absolutely, definitely, of
course, certainly, indeed, that's the one, that's the spot, that's the right spot, right there,
right spot, exactly there, exactly right, that's exactly it, there, just there, here is good,
there is good, that's the place, this is the place, good position, good spot, perfect spot,
perfect position, great job, good job, well done, nice one, bingo, spot on, bullseye, on point,
all good, all right, it's ok, it's okay, that's ok, that's okay, that is fine, good enough, close
enough, that'll do, that will do, it will do, this will do, fine go, okay that's good, now it's
good, now it's perfect, now it is right, now go, much better go, better, much better thanks,
that's better go, yes that's it, yes that's right, yes that's perfect, yes perfect, yes good, yes
exactly, yes there, yes correct, yes this is good, yes I am sure, sure go ahead, sure do it,
sounds good, sounds great, happy with that, happy with this, no more changes, no changes needed,
nothing to change, leave it there, leave it like that, leave it, keep it there, keep that, keep
this position, don't change it, don't move it any more, stop there that's perfect, stop there it's
good, no need to correct, no correction needed, thumbs up, green light, you have my go, go go go,
make it so, engage, send it, ship it, k, kk, y, ya, aye, okey dokey, ok perfect, ok great, ok
good, ok thanks, thank you that's good, perfect thanks, great thanks, excellent go ahead, perfect
go ahead, perfect do it, place it there, put it there, put your hand there, lean there, reach it
now, move there, move now, go to that point, take that one, use that point, use this point, that
point is good, the point is good, the point is perfect, the target is good, the target is right,
target ok, position ok, position is good, the position is fine, the location is good, the location
is perfect, the spot is right, your prediction is right, you got it, you are right, you
understood, correct position, right position, right place
""")
FIRST = names("""
yes, ok, okay, great, perfect, yeah, good, yep, alright, excellent, nice, cool, well done, fine,
sure, thanks, exactly, now
""")
SECOND = names("""
go, do it, go ahead, that's it, that's perfect, that's good, that's right, looks good, perfect,
it's good, I like it, proceed, confirmed, execute, let's go, you can go, lean there, move now,
start, this is good, thank you, thanks, please, robot, go on with it, go for it, exactly there,
that's the spot, that works, well done, you can proceed, I'm happy with it, now go, do it now, now
do it
""")
TAILS = names("""
thanks, thank you, robot, please, now, go, talos, mate, buddy, then, for me, do it, you can go, go
ahead, well done, now lean, now reach, with that, there, like this, like that, I think, really,
indeed, very much, very good, !
""")
MORE = ("very", "really", "quite", "absolutely", "just", "totally", "pretty", "so")
GOOD = (
    "good",
    "perfect",
    "great",
    "fine",
    "right",
    "nice",
    "correct",
    "ok",
    "okay",
    "excellent",
    "ideal",
    "better",
    "well placed",
    "where I want it",
    "what I wanted",
    "what I meant",
    "what I want",
)
SUBJECTS = (
    "that is",
    "that's",
    "this is",
    "it is",
    "it's",
    "the point is",
    "the target is",
    "the position is",
    "now it's",
    "this looks",
    "that looks",
    "it looks",
    "the spot is",
    "the location is",
    "the contact is",
    "that seems",
    "it seems",
)


def confirmation(draw: Draw) -> Draft:
    """Return one way to say yes."""
    draft = Draft()
    kind = draw.below(10)
    if kind < 5:
        draft.add(draw.pick(YES))
    elif kind < 8:
        draft.add(draw.pick(FIRST))
        if draw.chance(0.6):
            draft.words[-1] += ","
        draft.add(draw.pick(SECOND))
    else:
        if draw.chance(0.3):
            draft.add(draw.pick(FIRST) + ",")
        more = draw.pick(MORE) if draw.chance(0.3) else ""
        draft.add(f"{draw.pick(SUBJECTS)} {more} {draw.pick(GOOD)}")
    if draw.chance(0.12):
        draft.add(draw.pick(TAILS))
    return draft
