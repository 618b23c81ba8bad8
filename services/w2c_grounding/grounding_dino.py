"""GroundingDINO through transformers; MM-GroundingDINO and LLMDet are the same but for weights.

Liu et al., "Grounding DINO: Marrying DINO with Grounded Pre-Training for Open-Set Object
Detection", ECCV 2024. A Swin backbone sees the picture; from the feature enhancer (section 3.1) on,
picture and text are mixed in every layer, so that only the backbone's work can be kept for the next
phrase.
"""

import re
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt
import torch
from transformers import AutoModelForZeroShotObjectDetection, GroundingDinoProcessor

from w2c_grounding.detections import evidence_of_detections, nothing
from w2c_grounding.family import Evidence, RgbImage
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.pretrained import Remembered, load_model, load_processor
from w2c_grounding.wording import FUNCTION_WORDS, fill, words

_ROWS = 4
"""Phrases of one batch: at the usual input size a row takes about 150 MB of activations, and a
larger batch is hardly faster."""

_LONGEST_OVER_SHORTEST = 1333 / 800
"""Of the input, as the public checkpoints were trained (section 4): the shorter side is scaled to
the input size unless the longer one would exceed this many times it."""

# The model splits its text into labels at these, whatever they meant in the phrase (section 3.4).
_SEPARATORS = re.compile(r"[.?]+")

_Levels = list[tuple[torch.Tensor, torch.Tensor]]
"""Of the backbone, finest first: features (1, channels, h, w) and which of them are picture"""


@dataclass(frozen=True)
class GroundingDinoContext:
    """What the backbone made of a picture."""

    width: int
    height: int
    input_height: int
    input_width: int
    levels: _Levels
    positions: list[torch.Tensor]


class _KeptBackbone(torch.nn.Module):
    """Stands where the backbone stood, and answers with what it made of the picture before."""

    def __init__(self, position_embedding: torch.nn.Module) -> None:
        super().__init__()
        self.position_embedding = position_embedding
        self.context: GroundingDinoContext | None = None

    def forward(
        self, pixel_values: torch.Tensor, _: torch.Tensor
    ) -> tuple[_Levels, list[torch.Tensor]]:
        """Return the kept features once for each row; lists of their own, since callers append."""
        if self.context is None:
            raise RuntimeError("the picture was not prepared; call prepare before query")
        rows = len(pixel_values)
        levels = [
            (features.expand(rows, -1, -1, -1), mask.expand(rows, -1, -1))
            for features, mask in self.context.levels
        ]
        return levels, [one.expand(rows, -1, -1, -1) for one in self.context.positions]


class GroundingDino:
    """A checkpoint of the family in memory. Thread-safe: phrases take turns.

    One phrase a row of the batch: labels in one text influence each other, and "man. ball." loses
    the ball that "ball." finds.
    """

    def __init__(
        self, model: Any, processor: Any, template: str, input_size: int | None = None
    ) -> None:
        # Any: transformers publishes no types for its model classes.
        self._model = model
        self._processor = processor
        self._template = template
        self._size = (
            {}
            if input_size is None
            else {
                "size": {
                    "shortest_edge": input_size,
                    "longest_edge": round(input_size * _LONGEST_OVER_SHORTEST),
                }
            }
        )
        self._backbone = model.model.backbone
        self._kept = _KeptBackbone(self._backbone.position_embedding)
        model.model.backbone = self._kept
        self._lock = threading.Lock()
        self._unknown = Remembered[tuple[str, ...]]()
        tokenizer = processor.tokenizer
        self._not_of_the_phrase = torch.tensor(
            [*tokenizer.all_special_ids, *tokenizer.convert_tokens_to_ids([".", "?"])]
        )
        # An unreadable word is a special token too, but one that stands for a part of the phrase.
        self._unreadable = tokenizer.unk_token_id

    @classmethod
    def load(cls, config: ModelConfig, source: str, template: str) -> Self:
        """Load from a directory or a hub id.

        Raises:
            ConfigError: the device does not exist here.
            ModelError: the files are missing, damaged, or of another architecture.
        """
        processor = load_processor(GroundingDinoProcessor, config, source, backend="pil")
        model = load_model(AutoModelForZeroShotObjectDetection, config, source)
        return cls(model, processor, template, config.input_size)

    @torch.inference_mode()
    def prepare(self, image: RgbImage) -> GroundingDinoContext:
        """Run the backbone once."""
        inputs = self._processor.image_processor(images=image, return_tensors="pt", **self._size)
        # The model does not cast them, and half precision fails on a float picture.
        pixels = inputs["pixel_values"].to(self._model.device, self._model.dtype)
        height, width = pixels.shape[-2:]
        mask = torch.ones((1, height, width), dtype=torch.long, device=pixels.device)
        levels, positions = self._backbone(pixels, mask)
        return GroundingDinoContext(
            image.shape[1], image.shape[0], height, width, levels, positions
        )

    def query(self, context: GroundingDinoContext, phrases: Sequence[str]) -> list[Evidence]:
        """Run text, feature enhancer and decoder for each phrase."""
        size = (context.width, context.height)
        unknown = [self._unknown.get(phrase, self._unknown_words) for phrase in phrases]
        readable = [
            phrase
            for phrase, missing in zip(phrases, unknown, strict=True)
            if set(words(phrase)) - set(missing) - FUNCTION_WORDS
        ]
        detections = self._detect(context, list(dict.fromkeys(readable)))
        return [
            evidence_of_detections(*detections[phrase], size, size, missing)
            if phrase in detections
            else nothing(size, missing)
            for phrase, missing in zip(phrases, unknown, strict=True)
        ]

    def _detect(
        self, context: GroundingDinoContext, phrases: Sequence[str]
    ) -> dict[str, tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]]:
        """Return the scores (queries,) and boxes (queries, 4) of each phrase."""
        found = {}
        for rows in _batches(phrases, _ROWS):
            scores, boxes = self._run(context, rows)
            found.update({row: (scores[i], boxes[i]) for i, row in enumerate(rows)})
        return found

    @torch.inference_mode()
    def _run(
        self, context: GroundingDinoContext, phrases: Sequence[str]
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """Return scores (rows, queries) and boxes (rows, queries, 4) of one batch."""
        device = self._model.device
        tokens = self._processor.tokenizer(
            [self._text(phrase) for phrase in phrases],
            padding=True,
            truncation=True,
            max_length=int(self._model.config.max_text_len),
            return_tensors="pt",
        ).to(device)
        # Only its shape is asked for now; expanded, so that it takes no memory.
        shape = (len(phrases), 3, context.input_height, context.input_width)
        picture = torch.empty(1, dtype=self._model.dtype, device=device).expand(shape)
        with self._lock:
            self._kept.context = context
            try:
                output = self._model(pixel_values=picture, **tokens)
            finally:
                self._kept.context = None
        ids = tokens["input_ids"]
        outside = torch.isin(ids, self._not_of_the_phrase.to(device)) & (ids != self._unreadable)
        # The logits go on beyond the text, up to the longest text that the model reads.
        logits = output.logits[:, :, : ids.shape[1]].float()
        logits = logits.masked_fill(outside[:, None, :], -torch.inf)
        scores = logits.amax(dim=2).sigmoid()
        return scores.cpu().numpy(), output.pred_boxes.float().cpu().numpy()

    def _text(self, phrase: str) -> str:
        """Return a label as the model was trained: lower case, one full stop, at its end."""
        inside = _SEPARATORS.sub(" ", fill(self._template, phrase).lower())
        return " ".join(inside.split()) + "."

    def _unknown_words(self, phrase: str) -> tuple[str, ...]:
        """Return the words of which the vocabulary does not have all pieces."""
        tokenizer = self._processor.tokenizer
        return tuple(
            word
            for word in dict.fromkeys(words(phrase))
            if self._unreadable in tokenizer(word, add_special_tokens=False)["input_ids"]
        )


def _batches(phrases: Sequence[str], size: int) -> Iterator[Sequence[str]]:
    for start in range(0, len(phrases), size):
        yield phrases[start : start + size]
