"""CLIPSeg through transformers: the public checkpoints, and this project's own of the same layout.

Lüddecke and Ecker, "Image Segmentation Using Text and Image Prompts", CVPR 2022. A CLIP picture
tower, a CLIP text tower, and a small transformer decoder whose features the text modulates.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import torch
from transformers import CLIPSegForImageSegmentation, CLIPSegProcessor

from w2c_grounding.evidence import heatmap_from_logits
from w2c_grounding.family import Evidence, RgbImage
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.pretrained import Remembered, load_model, load_processor
from w2c_grounding.tiles import with_tiles
from w2c_grounding.wording import fill


@dataclass(frozen=True)
class ClipSegContext:
    """The activations of the picture tower that the decoder reads."""

    width: int
    height: int
    activations: tuple[torch.Tensor, ...]
    """Each (1, tokens, hidden), of the layers in `config.extract_layers`"""
    pixels: torch.Tensor
    """(1, 3, side, side), normalised: what the tower saw"""


class ClipSeg:
    """A CLIPSeg checkpoint in memory. Thread-safe."""

    def __init__(
        self, model: Any, processor: Any, template: str, input_size: int | None = None
    ) -> None:
        # Any: transformers publishes no types for its model classes.
        self._model = model.eval()
        self._processor = processor
        self._template = template
        # The decoder takes its features for a square grid.
        self._size = (
            {} if input_size is None else {"size": {"height": input_size, "width": input_size}}
        )
        self._longest_text = int(model.config.text_config.max_position_embeddings)
        self._embeddings = Remembered[torch.Tensor]()

    @classmethod
    def load(cls, config: ModelConfig, source: str, template: str) -> Self:
        """Load from a directory or a hub id.

        Raises:
            ConfigError: the device does not exist here.
            ModelError: the files are missing, damaged, or of another architecture.
        """
        processor = load_processor(CLIPSegProcessor, config, source, backend="pil")
        model = load_model(CLIPSegForImageSegmentation, config, source)
        model.decoder = with_tiles(model.decoder)
        return cls(model, processor, template, config.input_size)

    @torch.inference_mode()
    def prepare(self, image: RgbImage) -> ClipSegContext:
        """Run the picture tower once."""
        pixels = self._processor.image_processor(images=image, return_tensors="pt", **self._size)[
            "pixel_values"
        ]
        pixels = pixels.to(self._model.device)
        output = self._model.clip.get_image_features(
            pixel_values=pixels,
            interpolate_pos_encoding=True,
            output_hidden_states=True,
        )
        # hidden_states[0] is the input of the first layer, so layer i is at i + 1.
        activations = tuple(output.hidden_states[layer + 1] for layer in self._model.extract_layers)
        return ClipSegContext(image.shape[1], image.shape[0], activations, pixels)

    @torch.inference_mode()
    def query(self, context: ClipSegContext, phrases: Sequence[str]) -> list[Evidence]:
        """Decode one heatmap a phrase from the activations of the picture."""
        conditions = torch.stack(self._embeddings.get_all(phrases, self._embed))
        count = len(phrases)
        activations = tuple(layer.expand(count, -1, -1) for layer in context.activations)
        logits = self._model.decoder(activations, conditions).logits.float().cpu().numpy()
        return [Evidence(heatmap_from_logits(one, context.width, context.height)) for one in logits]

    def _embed(self, phrases: list[str]) -> list[torch.Tensor]:
        """Return the text embedding (projection,) of each phrase.

        Padding comes after what is read, and the text tower looks only back: it changes nothing.
        """
        tokens = self._processor.tokenizer(
            [fill(self._template, phrase) for phrase in phrases],
            padding=True,
            truncation=True,
            max_length=self._longest_text,
            return_tensors="pt",
        ).to(self._model.device)
        features = self._model.clip.get_text_features(
            input_ids=tokens["input_ids"], attention_mask=tokens["attention_mask"]
        )
        return list(features.pooler_output)
