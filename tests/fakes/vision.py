"""A vision model that sees what it is told to."""

from collections.abc import Callable, Sequence

import numpy as np

from w2c_grounding.family import Evidence, Heatmap, RgbImage


class FakeFamily:
    """Family whose heatmaps are bright where the picture has the colour that the phrase names.

    Knows "red", "green" and "blue", each exactly the pure channel; counts what it is asked.
    """

    def __init__(self, before_query: Callable[[], None] = lambda: None) -> None:
        self.prepared = 0
        self.asked: list[str] = []
        self._before_query = before_query

    def prepare(self, image: RgbImage) -> RgbImage:
        """Keep the picture."""
        self.prepared += 1
        return image

    def query(self, context: RgbImage, phrases: Sequence[str]) -> list[Evidence]:
        """Return 1 where a channel is far above the others."""
        self._before_query()
        self.asked += phrases
        return [Evidence(self._heat(context, phrase)) for phrase in phrases]

    @staticmethod
    def _heat(image: RgbImage, phrase: str) -> Heatmap:
        heat = np.zeros(image.shape[:2], dtype=np.float32)
        for channel, colour in enumerate(("red", "green", "blue")):
            if colour in phrase:
                others = np.delete(image, channel, axis=2).max(axis=2).astype(int)
                heat[image[:, :, channel].astype(int) - others > 100] = 0.9
        return heat
