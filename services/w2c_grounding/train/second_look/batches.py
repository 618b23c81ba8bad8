"""One step's squares and questions: which squares each phrase fits.

Those of its picture are asked, and things of its kind in the other pictures of the step.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch

from w2c_grounding.second_look import crops
from w2c_grounding.second_look.network import SecondLookNetwork, said
from w2c_grounding.sizes import SIZE_WORDS
from w2c_grounding.train.asker import Asker, Question
from w2c_grounding.train.near_views import cut_otherwise, lit_otherwise
from w2c_grounding.train.second_look import squares as stored
from w2c_grounding.train.second_look.kinds import Kinds
from w2c_grounding.train.second_look.squares import Squares

BY_CHANCE = 6
"""Pictures of a step"""
GROUPS, OF_A_GROUP = 3, 4
"""And besides them so many that hold one kind of thing, for some kinds"""
TELLING = 3
"""Phrases of such a picture that tell its thing of that kind from others of it"""
PRESENT, ABSENT = 8, 4
"""Phrases of a picture in a step"""
DRAWN = 3
"""Times as many are drawn once for each picture; a step takes some of them: drawing takes longer
than learning"""
_NOMINAL = (1.0 + crops.MARGIN) / (1.0 + stored.MARGIN)
"""Side of what is cut at run time, over that of what was cut out here"""
SCALES = (0.8, 1.2)
"""Of the side that is cut, from one square to the other"""
SHIFT = 0.12
"""Of the middle, at most, in halves of the side that was cut out"""


@dataclass(frozen=True)
class SquareBatch:
    """What one step learns from."""

    squares: torch.Tensor
    """(n, 3, side, side), 0 to 1"""
    numbers: npt.NDArray[np.int64]
    """(n,) of the squares in the set"""
    phrases: list[str]
    pairs: torch.Tensor
    """(p, 2) square and phrase, both of this batch; those of a phrase are together"""
    fits: torch.Tensor
    """(p,) 1 where the phrase fits what the square shows, else 0"""


class SquareBatches:
    """Draws the batch of any step: a function of seed and step."""

    def __init__(self, squares: Squares, network: SecondLookNetwork, seed: int) -> None:
        self._squares = squares
        self._seed = seed
        self._known = network.numbers
        self._asker = Asker(squares.truths)
        self._kinds = Kinds(squares)
        self._drawn: dict[int, tuple[list[Question], list[Question]]] = {}

    def make(self, step: int) -> SquareBatch:
        """Return the batch of a step."""
        rng = np.random.default_rng([self._seed, 6, step])
        alike = self._kinds.draw(GROUPS, OF_A_GROUP, rng)
        others = rng.choice(len(self._squares.truths), BY_CHANCE)
        # A picture that was drawn twice would be asked against itself.
        pictures = dict([*((number, "") for number in others.tolist()), *alike])
        numbers = [n for picture in pictures for n in self._squares.of_picture[picture]]
        place = {number: n for n, number in enumerate(numbers)}
        phrases: list[str] = []
        answers: list[list[tuple[int, bool]]] = []
        for picture, kind in pictures.items():
            mine = self._squares.of_picture[picture]
            foreign = [number for number in numbers if number not in mine]
            for question in self._questions(picture, kind, rng):
                phrases.append(question.phrase)
                answers.append(self._answers(question, mine, foreign))
        chosen = np.array(numbers)
        generator = torch.Generator().manual_seed(int(rng.integers(2**31)))
        pixels = torch.from_numpy(self._squares.pixels[chosen]).permute(0, 3, 1, 2)
        return SquareBatch(
            squares=_seen_otherwise(pixels.float() / 255.0, generator),
            numbers=chosen,
            phrases=phrases,
            pairs=torch.tensor(
                [(place[number], n) for n, given in enumerate(answers) for number, _ in given]
            ),
            fits=torch.tensor(
                [right for given in answers for _, right in given], dtype=torch.float32
            ),
        )

    def _questions(self, picture: int, kind: str, rng: np.random.Generator) -> list[Question]:
        """Return what is asked of a picture; `kind` = that it was chosen for, "" = by chance."""
        asked = self._some(picture, rng)
        if kind:
            telling = self._kinds.questions(self._squares.truths[picture], kind, TELLING, rng)
            asked += [one for one in telling if self._is_known(one.phrase)]
        return asked

    def _answers(
        self, question: Question, mine: range, foreign: Sequence[int]
    ) -> list[tuple[int, bool]]:
        """Return which squares of a step a question of one picture means."""
        here = self._here(mine, question)
        cuts = [self._squares.cuts[number] for number, right in here if right]
        meant = [cut.item for cut in cuts if cut.item is not None]
        return [*here, *self._kinds.elsewhere(question.phrase, meant, foreign)]

    def _here(self, mine: range, question: Question) -> list[tuple[int, bool]]:
        """Return which squares of its own picture a question means."""
        answers = []
        for number in mine:
            one = self._squares.cuts[number]
            meant = one.inside.intersection(question.identities)
            if one.item is None and meant:
                continue  # a piece of it, perhaps: neither right nor wrong
            answers.append((number, bool(meant)))
        return answers

    def _some(self, picture: int, rng: np.random.Generator) -> list[Question]:
        if picture not in self._drawn:
            self._drawn[picture] = self._draw(picture)
        present, absent = self._drawn[picture]
        return [*_sample(present, PRESENT, rng), *_sample(absent, ABSENT, rng)]

    def _draw(self, picture: int) -> tuple[list[Question], list[Question]]:
        truth = self._squares.truths[picture]
        rng = np.random.default_rng([self._seed, 7, picture])
        clear = truth.clearly_visible()
        found = self._asker.ask(truth, clear, DRAWN * PRESENT, DRAWN * ABSENT, rng)
        known = [one for one in found if self._is_known(one.phrase)]
        return [one for one in known if one.identities], [
            one for one in known if not one.identities
        ]

    def _is_known(self, phrase: str) -> bool:
        """Tell whether all its words are known, and none is of sizes, which are compared."""
        return all(word in self._known and word not in SIZE_WORDS for word in said(phrase))


def _sample(questions: Sequence[Question], count: int, rng: np.random.Generator) -> list[Question]:
    chosen = rng.permutation(len(questions))[:count]
    return [questions[int(n)] for n in chosen]


def _seen_otherwise(squares: torch.Tensor, generator: torch.Generator) -> torch.Tensor:
    """Return squares as at run time, each cut, turned over and lit a little differently."""
    cut = cut_otherwise(squares, crops.SIDE, _NOMINAL, SCALES, SHIFT, generator)
    return lit_otherwise(cut, generator)
