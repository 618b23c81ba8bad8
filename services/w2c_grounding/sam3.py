"""SAM 3 through transformers: every instance of a phrase, with its mask.

Carion et al., "SAM 3: Segment Anything with Concepts", 2025. A detector with a presence head, which
says whether the picture shows the phrase at all, and a mask for each query.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt
import torch

from w2c_grounding.adapters import heatmap_from_masks
from w2c_grounding.family import Evidence, RgbImage, ScoredBox
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.pretrained import Remembered, load_model, load_processor
from w2c_grounding.torchvision_build import need_torchvision
from w2c_grounding.wording import fill

MAX_INSTANCES = 20
"""The best of a phrase that are drawn; the model has 200 queries, nearly all of them empty"""

_LONGEST_PHRASE = 32
"""[tokens], as the model was trained"""


@dataclass(frozen=True)
class Sam3Context:
    """What the image tower keeps of a picture."""

    width: int
    height: int
    embeddings: Any
    """Of transformers, opaque here"""


class Sam3:
    """A SAM 3 checkpoint in memory. One thread at a time."""

    def __init__(self, model: Any, processor: Any, template: str) -> None:
        # Any: transformers publishes no types for its model classes.
        self._model = model.eval()
        self._processor = processor
        self._template = template
        self._texts = Remembered[tuple[Any, torch.Tensor]]()

    @classmethod
    def load(cls, config: ModelConfig, source: str, template: str) -> Self:
        """Load from a directory or a hub id.

        Raises:
            ConfigError: torchvision is missing, or the device does not exist here.
            ModelError: the files are missing, damaged, or of another architecture.
        """
        need_torchvision("family sam3")
        from transformers import Sam3Model, Sam3Processor

        processor = load_processor(Sam3Processor, config, source)
        return cls(load_model(Sam3Model, config, source), processor, template)

    @torch.inference_mode()
    def prepare(self, image: RgbImage) -> Sam3Context:
        """Run the image tower once."""
        inputs = self._processor.image_processor(images=image, return_tensors="pt")
        pixels = inputs["pixel_values"].to(self._model.device, self._model.dtype)
        embeddings = self._model.get_vision_features(pixel_values=pixels)
        return Sam3Context(image.shape[1], image.shape[0], embeddings)

    def query(self, context: Sam3Context, phrases: Sequence[str]) -> list[Evidence]:
        """Detect the instances of each phrase.

        One phrase after the other: the tower, which takes most of the time, has run already, and a
        batch would hold its features once for each phrase.
        """
        return [self._answer(context, phrase) for phrase in phrases]

    @torch.inference_mode()
    def _answer(self, context: Sam3Context, phrase: str) -> Evidence:
        text, mask = self._texts.get(phrase, self._text)
        output = self._model(
            vision_embeds=context.embeddings, text_embeds=text, attention_mask=mask
        )
        scores = output.pred_logits[0].sigmoid()
        if output.presence_logits is not None:
            scores = scores * output.presence_logits[0].sigmoid()
        best = scores.argsort(descending=True)[:MAX_INSTANCES]
        return evidence_of(
            scores[best].float().cpu().numpy(),
            output.pred_boxes[0, best].float().cpu().numpy(),
            output.pred_masks[0, best].sigmoid().float().cpu().numpy(),
            context.width,
            context.height,
        )

    def _text(self, phrase: str) -> tuple[Any, torch.Tensor]:
        """Return what the text tower makes of a phrase, and which of it is no padding."""
        tokens = self._processor.tokenizer(
            [fill(self._template, phrase)],
            padding="max_length",
            max_length=_LONGEST_PHRASE,
            truncation=True,
            return_tensors="pt",
        ).to(self._model.device)
        mask = tokens["attention_mask"]
        return self._model.get_text_features(tokens["input_ids"], attention_mask=mask), mask


def evidence_of(
    scores: npt.NDArray[np.float32],
    boxes: npt.NDArray[np.float32],
    masks: npt.NDArray[np.float32],
    width: int,
    height: int,
) -> Evidence:
    """Return the evidence of some instances.

    Args:
        scores: (n,), 0 to 1.
        boxes: (n, 4): left, top, right, bottom, as shares of the picture.
        masks: (n, h, w), probabilities over the whole picture at a lower resolution.
        width: Of the picture [px].
        height: Of the picture [px].
    """
    pixels = boxes * np.array([width, height, width, height], dtype=np.float32)
    found = tuple(
        ScoredBox(left, top, right, bottom, score)
        for (left, top, right, bottom), score in zip(pixels.tolist(), scores.tolist(), strict=True)
    )
    return Evidence(heatmap_from_masks(list(masks), scores.tolist(), width, height), found)
