"""CLIPSeg through transformers: the public checkpoints, and this project's own of the same layout.

Lüddecke and Ecker, "Image Segmentation Using Text and Image Prompts", CVPR 2022. A CLIP picture
tower, a CLIP text tower, and a small transformer decoder whose features the text modulates.
"""

import threading
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import torch
from transformers import CLIPSegForImageSegmentation, CLIPSegProcessor
from transformers.utils import logging as transformers_logging

from w2c.errors import ConfigError, ModelError
from w2c_grounding.evidence import heatmap_from_logits
from w2c_grounding.family import Evidence, RgbImage
from w2c_grounding.model_config import Dtype, ModelConfig
from w2c_grounding.wording import fill

_DTYPES: dict[Dtype, torch.dtype] = {
    "float32": torch.float32,
    "bfloat16": torch.bfloat16,
    "float16": torch.float16,
}

# Phrases of a session repeat; an embedding is a few kilobytes, so this bounds memory to a few
# megabytes.
_REMEMBERED_PHRASES = 1000


@dataclass(frozen=True)
class ClipSegContext:
    """The activations of the picture tower that the decoder reads."""

    width: int
    height: int
    activations: tuple[torch.Tensor, ...]
    """Each (1, tokens, hidden), of the layers in `config.extract_layers`"""


class ClipSeg:
    """A CLIPSeg checkpoint in memory. Thread-safe."""

    def __init__(self, model: Any, processor: Any, template: str) -> None:
        # Any: transformers publishes no types for its model classes.
        self._model = model.eval()
        self._processor = processor
        self._template = template
        self._longest_text = int(model.config.text_config.max_position_embeddings)
        self._embeddings: OrderedDict[str, torch.Tensor] = OrderedDict()
        self._lock = threading.Lock()

    @classmethod
    def load(cls, config: ModelConfig, source: str, template: str) -> Self:
        """Load from a directory or a hub id.

        Raises:
            ConfigError: the device does not exist here.
            ModelError: the files are missing, damaged, or of another architecture.
        """
        torch.set_num_threads(config.threads)
        transformers_logging.disable_progress_bar()  # type: ignore[no-untyped-call]
        where: dict[str, Any] = {"local_files_only": not config.allow_download}
        if config.revision:
            where["revision"] = config.revision
        try:
            processor = CLIPSegProcessor.from_pretrained(source, backend="pil", **where)
            model: Any = CLIPSegForImageSegmentation.from_pretrained(
                source, dtype=_DTYPES[config.dtype], **where
            )
        # transformers, safetensors and the tokenizer each have errors of their own for damaged
        # files.
        except Exception as error:
            raise ModelError(
                f"CLIPSeg cannot be loaded from '{source}': {error}. "
                "Give a checkpoint directory, or a hub id with --allow-download"
            ) from error
        try:
            model = model.to(config.device)
        except (RuntimeError, AssertionError) as error:
            raise ConfigError(
                f"device '{config.device}' cannot be used: {error}; try --device cpu"
            ) from error
        return cls(model, processor, template)

    @torch.inference_mode()
    def prepare(self, image: RgbImage) -> ClipSegContext:
        """Run the picture tower once."""
        pixels = self._processor.image_processor(images=image, return_tensors="pt")["pixel_values"]
        output = self._model.clip.get_image_features(
            pixel_values=pixels.to(self._model.device),
            interpolate_pos_encoding=True,
            output_hidden_states=True,
        )
        # hidden_states[0] is the input of the first layer, so layer i is at i + 1.
        activations = tuple(output.hidden_states[layer + 1] for layer in self._model.extract_layers)
        return ClipSegContext(image.shape[1], image.shape[0], activations)

    @torch.inference_mode()
    def query(self, context: ClipSegContext, phrases: Sequence[str]) -> list[Evidence]:
        """Decode one heatmap a phrase from the activations of the picture."""
        conditions = torch.stack([self._embedding(phrase) for phrase in phrases])
        count = len(phrases)
        activations = tuple(layer.expand(count, -1, -1) for layer in context.activations)
        logits = self._model.decoder(activations, conditions).logits.float().cpu().numpy()
        return [Evidence(heatmap_from_logits(one, context.width, context.height)) for one in logits]

    def _embedding(self, phrase: str) -> torch.Tensor:
        """Return the text embedding (projection,) of a phrase, from memory where it is known."""
        with self._lock:
            if phrase in self._embeddings:
                self._embeddings.move_to_end(phrase)
                return self._embeddings[phrase]
        tokens = self._processor.tokenizer(
            [fill(self._template, phrase)],
            truncation=True,
            max_length=self._longest_text,
            return_tensors="pt",
        ).to(self._model.device)
        features = self._model.clip.get_text_features(
            input_ids=tokens["input_ids"], attention_mask=tokens["attention_mask"]
        )
        embedding: torch.Tensor = features.pooler_output[0]
        with self._lock:
            self._embeddings[phrase] = embedding
            while len(self._embeddings) > _REMEMBERED_PHRASES:
                self._embeddings.popitem(last=False)
        return embedding
