"""A family whose lack of memory is an answer in words, after which it goes on."""

from collections.abc import Sequence
from typing import Any, Generic

from w2c.errors import RefusedError
from w2c_grounding.family import ContextT, Evidence, Family, RgbImage


class Guarded(Generic[ContextT]):
    """Wraps a family: many phrases that do not fit into memory together are asked in halves.

    What does not fit alone either is refused with what to change. Other failures pass through.
    """

    def __init__(self, family: Family[ContextT], device: str) -> None:
        self.family = family
        """The family itself"""
        self._device = device

    def prepare(self, image: RgbImage) -> ContextT:
        """Return what the model keeps of a picture. Raises RefusedError."""
        try:
            return self.family.prepare(image)
        except (MemoryError, RuntimeError) as error:
            if not is_out_of_memory(error):
                raise
        height, width = image.shape[:2]
        release(self._device)
        raise RefusedError(
            f"the vision model ran out of memory on {self._device} with a picture of {width} x "
            f"{height} px; {_ADVICE}"
        )

    def query(self, context: ContextT, phrases: Sequence[str]) -> list[Evidence]:
        """Return the evidence for each phrase. Raises RefusedError."""
        try:
            return self.family.query(context, phrases)
        except (MemoryError, RuntimeError) as error:
            if not is_out_of_memory(error):
                raise
        # Only here is the failed attempt's memory free again: its error held on to it.
        release(self._device)
        if len(phrases) == 1:
            raise RefusedError(
                f"the vision model ran out of memory on {self._device} with one phrase; {_ADVICE}"
            )
        half = (len(phrases) + 1) // 2
        return [*self.query(context, phrases[:half]), *self.query(context, phrases[half:])]


_ADVICE = (
    "end other programs there, or start grounding with --dtype bfloat16, a smaller --input-size, a "
    "smaller --model, or --device cpu"
)


def is_out_of_memory(error: BaseException) -> bool:
    """Return whether memory was what an error was about, of the computer or of a GPU."""
    if isinstance(error, MemoryError):
        return True
    import torch

    # On a CPU torch has no type of its own for it.
    return isinstance(error, torch.OutOfMemoryError) or "can't allocate memory" in str(error)


def is_device_lost(error: BaseException) -> bool:
    """Return whether a GPU failed so that this process can use it no more: all later calls fail."""
    import torch

    return isinstance(error, torch.AcceleratorError)


def release(device: str) -> None:
    """Give back what torch keeps of a GPU's memory for later."""
    if device.startswith("cuda"):
        import torch

        cuda: Any = torch.cuda  # untyped
        cuda.empty_cache()
