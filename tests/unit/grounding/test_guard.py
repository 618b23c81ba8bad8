"""Lack of memory is an answer in words, and the next request is answered."""

from collections.abc import Sequence

import numpy as np
import pytest
import torch

from fakes.vision import FakeFamily
from w2c.errors import RefusedError
from w2c_grounding.family import Evidence, RgbImage
from w2c_grounding.guard import Guarded

IMAGE = np.zeros((6, 8, 3), dtype=np.uint8)


class SmallMemory(FakeFamily):
    """Runs out of memory with more phrases than fit, or with a picture that is too large."""

    def __init__(self, fits: int, error: Exception, pixels: int = 1000) -> None:
        super().__init__()
        self._fits = fits
        self._error = error
        self._pixels = pixels

    def prepare(self, image: RgbImage) -> RgbImage:
        if image.shape[0] * image.shape[1] > self._pixels:
            raise self._error
        return super().prepare(image)

    def query(self, context: RgbImage, phrases: Sequence[str]) -> list[Evidence]:
        if len(phrases) > self._fits:
            raise self._error
        return super().query(context, phrases)


ERRORS = [
    torch.OutOfMemoryError("CUDA out of memory. Tried to allocate 2.00 GiB"),
    RuntimeError("[enforce fail at alloc_cpu.cpp:124] DefaultCPUAllocator: can't allocate memory"),
    MemoryError("Unable to allocate 2.00 GiB for an array"),
]


@pytest.mark.parametrize("error", ERRORS, ids=["cuda", "cpu", "numpy"])
def test_phrases_that_do_not_fit_together_are_asked_in_parts_in_their_order(
    error: Exception,
) -> None:
    family = SmallMemory(2, error)
    phrases = ["red", "green", "blue", "red one", "green one"]
    evidence = Guarded(family, "cpu").query(IMAGE, phrases)
    assert len(evidence) == 5
    assert family.asked == phrases


@pytest.mark.parametrize("error", ERRORS, ids=["cuda", "cpu", "numpy"])
def test_what_does_not_fit_alone_is_refused_with_what_to_change(error: Exception) -> None:
    family = SmallMemory(0, error)
    guarded = Guarded(family, "cpu")
    with pytest.raises(RefusedError, match=r"ran out of memory on cpu with one phrase.*--dtype"):
        guarded.query(IMAGE, ["red", "green"])
    with pytest.raises(RefusedError, match=r"a picture of 80 x 60 px.*--input-size"):
        guarded.prepare(np.zeros((60, 80, 3), dtype=np.uint8))
    family._fits = 1
    assert len(guarded.query(guarded.prepare(IMAGE), ["red"])) == 1


def test_other_failures_pass_through() -> None:
    family = SmallMemory(0, RuntimeError("shapes cannot be multiplied"))
    with pytest.raises(RuntimeError, match="shapes"):
        Guarded(family, "cpu").query(IMAGE, ["red"])
