"""OWLv2 through transformers.

Minderer, Gritsenko and Houlsby, "Scaling Open-Vocabulary Object Detection", NeurIPS 2023. Every
patch of a picture tower proposes one box; the similarity of its class embedding with that of a text
is its score. Boxes do not depend on the text, so that a phrase costs one text embedding and one
product.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import cv2
import numpy as np
import numpy.typing as npt
import torch
from transformers import Owlv2ForObjectDetection, Owlv2Processor

from w2c_grounding.detections import evidence_of_detections
from w2c_grounding.family import Evidence, RgbImage
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.pretrained import Remembered, load_model, load_processor
from w2c_grounding.wording import fill


@dataclass(frozen=True)
class Owlv2Context:
    """What the picture tower and the box head made of a picture."""

    width: int
    height: int
    features: torch.Tensor
    """(1, patches, hidden)"""
    boxes: npt.NDArray[np.float32]
    """(patches, 4), centre and size as fractions of the padded square"""


class Owlv2:
    """An OWLv2 checkpoint in memory. Thread-safe."""

    def __init__(
        self, model: Any, processor: Any, template: str, input_size: int | None = None
    ) -> None:
        # Any: transformers publishes no types for its model classes.
        self._model = model
        self._processor = processor
        self._template = template
        self._side = input_size or int(model.config.vision_config.image_size)
        self._longest_text = int(model.config.text_config.max_position_embeddings)
        self._embeddings = Remembered[torch.Tensor]()

    @classmethod
    def load(cls, config: ModelConfig, source: str, template: str) -> Self:
        """Load from a directory or a hub id.

        Raises:
            ConfigError: the device does not exist here.
            ModelError: the files are missing, damaged, or of another architecture.
        """
        processor = load_processor(Owlv2Processor, config, source, backend="pil")
        model = load_model(Owlv2ForObjectDetection, config, source)
        return cls(model, processor, template, config.input_size)

    @torch.inference_mode()
    def prepare(self, image: RgbImage) -> Owlv2Context:
        """Run the picture tower and the box head once."""
        inputs = self._processor.image_processor(
            images=_bounded(image, 2 * self._side),
            size={"height": self._side, "width": self._side},
            return_tensors="pt",
        )
        pixels = inputs["pixel_values"].to(self._model.device, self._model.dtype)
        grid, _ = self._model.image_embedder(pixels, interpolate_pos_encoding=True)
        features = grid.flatten(1, 2)  # (1, h, w, hidden) -> (1, patches, hidden)
        boxes = self._model.box_predictor(features, grid, interpolate_pos_encoding=True)
        return Owlv2Context(
            image.shape[1], image.shape[0], features, boxes[0].float().cpu().numpy()
        )

    @torch.inference_mode()
    def query(self, context: Owlv2Context, phrases: Sequence[str]) -> list[Evidence]:
        """Compare every patch with every phrase."""
        texts = torch.stack([self._embeddings.get(phrase, self._embedding) for phrase in phrases])
        logits, _ = self._model.class_predictor(context.features, texts[None])
        scores = logits[0].float().sigmoid().cpu().numpy()  # (patches, phrases)
        # The picture lies at the top left of a square: the rest is padding.
        extent = (float(max(context.width, context.height)),) * 2
        size = (context.width, context.height)
        return [
            evidence_of_detections(scores[:, index], context.boxes, extent, size)
            for index in range(len(phrases))
        ]

    def _embedding(self, phrase: str) -> torch.Tensor:
        """Return the text embedding (projection,) of a phrase; the class head scales it to 1."""
        tokens = self._processor.tokenizer(
            [fill(self._template, phrase)],
            truncation=True,
            max_length=self._longest_text,
            return_tensors="pt",
        ).to(self._model.device)
        features = self._model.owlv2.get_text_features(
            input_ids=tokens["input_ids"], attention_mask=tokens["attention_mask"]
        )
        embedding: torch.Tensor = features.pooler_output[0]
        return embedding


def _bounded(image: RgbImage, longest: int) -> RgbImage:
    """Return the picture, no side longer than this [px], its shape kept.

    The processor pads to a square and filters in float64: of 40 megapixels that takes gigabytes.
    """
    scale = longest / max(image.shape[:2])
    if scale >= 1.0:
        return image
    size = (max(1, round(image.shape[1] * scale)), max(1, round(image.shape[0] * scale)))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
