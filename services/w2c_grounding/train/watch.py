"""A cheap look at how far a training is: the arg-max on a few pictures that were kept back."""

from typing import Any

import numpy as np
import torch

from w2c_grounding.train.asker import Asker
from w2c_grounding.train.augment import normalise
from w2c_grounding.train.data import MIN_VISIBLE_SHARE, cropped
from w2c_grounding.train.model import Size, decode, embed, features
from w2c_grounding.train.pictures import Pictures

PICTURES = 32
PRESENT, ABSENT = 6, 2


@torch.inference_mode()
def watch(
    model: Any, processor: Any, pictures: Pictures, size: Size, seed: int
) -> tuple[float, float]:
    """Return two rates on up to `PICTURES` pictures; the same questions whenever it is asked.

    Returns:
        How often the arg-max lies on what was asked for; and how often what is asked for in vain
        peaks lower than three quarters of what is there.
    """
    asker = Asker(pictures.truths)
    rng = np.random.default_rng([seed, 3])
    hits: list[bool] = []
    there: list[float] = []
    vain: list[float] = []
    for index in range(min(PICTURES, len(pictures))):
        owners = np.array(pictures.identities[index])
        shown = np.bincount(owners.reshape(-1), minlength=256)
        whole = pictures.truths[index]
        counts = {item.id: int(shown[item.id]) for item in whole.objects}
        truth = cropped(whole, size.image, size.image, counts)
        least = MIN_VISIBLE_SHARE * size.image**2
        clear = [item for item in truth.objects if item.visible_pixels >= least]
        questions = asker.ask(truth, clear, PRESENT, ABSENT, rng)
        pixels = torch.from_numpy(np.array(pictures.pixels[index])).permute(2, 0, 1)[None] / 255.0
        tokens = processor.tokenizer(
            [question.phrase for question in questions],
            padding=True,
            truncation=True,
            max_length=size.longest_phrase,
            return_tensors="pt",
        )
        logits = decode(model, features(model, normalise(pixels)), embed(model, tokens), (1, 1), 2)
        sparse = owners[1::2, 1::2]
        for question, heat in zip(questions, logits.numpy(), strict=True):
            peak = np.unravel_index(int(heat.argmax()), heat.shape)
            if question.identities:
                hits.append(int(sparse[peak]) in question.identities)
                there.append(float(heat[peak]))
            else:
                vain.append(float(heat[peak]))
    if not hits or not vain:
        return float("nan"), float("nan")
    level = float(np.quantile(there, 0.25))
    return float(np.mean(hits)), float(np.mean(np.array(vain) < level))
