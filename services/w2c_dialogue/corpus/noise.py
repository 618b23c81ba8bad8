"""What typing does to words: slips, missing articles, capitals, punctuation."""

from w2c_dialogue.corpus.draft import Draft
from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.things import meanings

DROPPABLE = frozenset({"the", "a", "your", "that", "my", "please"})
NEIGHBOURS = {
    key: near
    for near, key in meanings("""
a: sq | b: vn | c: xv | d: sf | e: wr | f: dg | g: fh | h: gj | i: uo | j: hk | k: jl | l: k | m:
n | n: bm | o: ip | p: o | q: w | r: et | s: ad | t: ry | u: yi | v: cb | w: qe | x: zc | y: tu |
z: x
""")
}
"""Keys of a keyboard, and the keys beside them."""
SPOKEN = ("um", "uh", "er", "well", "so", "hmm", "like")


def slip(word: str, draw: Draw) -> str:
    """Return a word with one typing error; short words and numbers are left alone."""
    if len(word) < 4 or not word.isalpha():
        return word
    at = 1 + draw.below(len(word) - 2)
    kind = draw.below(4)
    if kind == 0:
        return word[:at] + word[at + 1 :]
    if kind == 1:
        return word[:at] + word[at] + word[at:]
    if kind == 2:
        return word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    return word[:at] + draw.pick(NEIGHBOURS.get(word[at].lower(), "e")) + word[at + 1 :]


def disturb(draft: Draft, draw: Draw) -> Draft:
    """Return the draft as someone in a hurry types it."""
    drop = draw.chance(0.15)
    slips = 0.05 if draw.chance(0.25) else 0.0
    words: list[str] = []
    letters: list[str] = []
    if draw.chance(0.04):
        words.append(draw.pick(SPOKEN) + ("," if draw.chance(0.5) else ""))
        letters.append("")
    for word, letter in zip(draft.words, draft.letters, strict=True):
        if drop and not letter and word.lower() in DROPPABLE and draw.chance(0.7):
            continue
        if letter and letters and letters[-1] == letter and words[-1].endswith(","):
            words[-1] = words[-1].rstrip(",")
        words.append(slip(word, draw) if slips and draw.chance(slips) else word)
        letters.append(letter)
    if not words:
        return draft
    if draw.chance(0.15):
        words = [word.rstrip(",") or word for word in words]
    if draw.chance(0.4):
        words[0] = words[0][:1].upper() + words[0][1:]
    elif draw.chance(0.04):
        words = [word.upper() for word in words]
    if draw.chance(0.35):
        words[-1] += draw.pick((".", ".", ".", "!", "...", " .")).strip()
    return Draft(words, letters)
