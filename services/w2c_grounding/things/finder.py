"""Finds the things of a picture in what the picture tower of a CLIPSeg saw."""

import numpy as np
import torch

from w2c_grounding.clipseg import ClipSegContext
from w2c_grounding.things.network import ThingsNetwork
from w2c_grounding.things.proposals import Thing, things_of


class ThingFinder:
    """A network of things in memory. Thread-safe."""

    def __init__(self, network: ThingsNetwork, device: str = "cpu") -> None:
        last = torch.channels_last
        self._network: ThingsNetwork = network.to(device).to(memory_format=last).eval()  # type: ignore[call-overload]

    @torch.inference_mode()
    def __call__(self, context: ClipSegContext) -> tuple[Thing, ...]:
        """Return the things of a picture, the surest first."""
        activations = tuple(one.float() for one in context.activations)
        pixels = context.pixels.float().contiguous(memory_format=torch.channels_last)
        answers = self._network(activations, pixels)
        there, fits, boxes = (np.asarray(one[0].float().cpu().numpy()) for one in answers)
        return things_of(there, fits, boxes)
