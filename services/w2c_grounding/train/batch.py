"""One step's pictures and questions: a function of seed and step, so that a training can go on."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch

from w2c_grounding.train.asker import FURNITURE, Asker, Question
from w2c_grounding.train.augment import Bytes, View, draw_view, look, relight
from w2c_grounding.train.data import MIN_VISIBLE_SHARE, ROBOT, ObjectTruth, PictureTruth, cropped
from w2c_grounding.train.model import Size
from w2c_grounding.train.pictures import Pictures
from w2c_grounding.train.plan import Plan, Progress

LEAST_SHARE = 0.4
"""Of what a picture shows of a thing: a window that shows less, and not much, does not ask for it.
Nobody knows a mug by its rim."""
PLENTY = 0.02
"""Of the picture: so much of a thing is enough to know it by"""


@dataclass(frozen=True)
class Batch:
    """What one step learns from."""

    pixels: torch.Tensor
    """(n, 3, h, w), 0 to 1"""
    owners: torch.Tensor
    """(n, h, w) uint8, ids of objects; 0 nothing, 255 the robot"""
    corners: torch.Tensor | None
    """(n, 2) where windows lie in their pictures [patches]; None for whole pictures"""
    truths: tuple[PictureTruth, ...]
    """Of what is shown"""
    questions: tuple[Question, ...]
    """Of the first picture, then of the second ..., equally many"""


class Batches:
    """Draws the batch of any step."""

    def __init__(self, pictures: Pictures, size: Size, plan: Plan, asker: Asker) -> None:
        self._pictures = pictures
        self._size = size
        self._plan = plan
        self._asker = asker
        self._least = MIN_VISIBLE_SHARE * size.image**2
        self._order: dict[int, npt.NDArray[np.int64]] = {}

    def make(self, progress: Progress) -> Batch:
        """Return the batch of the next step."""
        plan, size, step = self._plan, self._size, progress.steps
        rng = np.random.default_rng([plan.seed, 1, step])
        late = progress.fraction(plan) >= plan.whole_from
        whole = late or rng.random() < plan.whole_share
        window = size.image if whole else min(plan.window_cells, size.cells) * size.patch
        count = plan.wholes(size.cells) if whole else plan.windows
        seen: list[tuple[Bytes, Bytes]] = []
        views: list[View] = []
        truths: list[PictureTruth] = []
        questions: list[Question] = []
        for index in self._indices(step * plan.windows, count):
            view, (colours, owners) = self._shot(index, window, rng)
            shown = np.bincount(owners.reshape(-1), minlength=256)
            counts = {item.id: int(shown[item.id]) for item in self._pictures.truths[index].objects}
            truth = cropped(self._pictures.truths[index], window, window, counts)
            clear = self._clear(self._pictures.truths[index], truth, view)
            questions += self._asker.ask(truth, clear, plan.present, plan.absent, rng)
            seen.append((colours, owners))
            views.append(view)
            truths.append(truth)
        pixels = torch.from_numpy(np.stack([colours for colours, _ in seen])).permute(0, 3, 1, 2)
        generator = torch.Generator().manual_seed(int(rng.integers(2**31)))
        return Batch(
            pixels=relight(pixels.float() / 255.0, generator),
            owners=torch.from_numpy(np.stack([owners for _, owners in seen])),
            corners=None if whole else torch.tensor([view.corner for view in views]),
            truths=tuple(truths),
            questions=tuple(questions),
        )

    def _indices(self, first: int, count: int) -> list[int]:
        """Return the `first`-th picture and those after it of an endless row of shuffled sets."""
        chosen = []
        for place in range(first, first + count):
            lap, position = divmod(place, len(self._pictures))
            if lap not in self._order:
                shuffled = np.random.default_rng([self._plan.seed, 2, lap])
                self._order = {lap: shuffled.permutation(len(self._pictures))}
            chosen.append(int(self._order[lap][position]))
        return chosen

    def _shot(
        self, index: int, window: int, rng: np.random.Generator
    ) -> tuple[View, tuple[Bytes, Bytes]]:
        """Return a view of a picture, around one of its things, and what it shows."""
        owners = np.array(self._pictures.identities[index])
        centre = None
        things = [
            item.id
            for item in self._pictures.truths[index].clearly_visible()
            if item.kind not in FURNITURE
        ]
        if things and window < self._size.image:
            rows, columns = np.nonzero(owners == things[int(rng.integers(len(things)))])
            if len(rows):
                centre = (float(columns.mean()), float(rows.mean()))
        view = draw_view(self._size.image, window, self._size.patch, centre, rng)
        return view, look(view, np.array(self._pictures.pixels[index]), owners)

    def _clear(self, whole: PictureTruth, truth: PictureTruth, view: View) -> list[ObjectTruth]:
        """Return the things that a view shows enough of to ask for them."""
        scale = self._size.image**2 / (whole.width * whole.height * view.zoom**2)
        expected = {item.id: scale * item.visible_pixels for item in whole.objects}
        plenty = PLENTY * self._size.image**2
        return [
            item
            for item in truth.objects
            if item.id != ROBOT
            and item.visible_pixels >= self._least
            and item.visible_pixels >= min(plenty, LEAST_SHARE * expected[item.id])
        ]
