"""CLIP Surgery: heatmaps from an unchanged CLIP, without training.

Li, Wang, Duan and Li, "CLIP Surgery for Better Explainability with Enhancement in Open-Vocabulary
Tasks", arXiv:2304.05653; later "A Closer Look at the Explainability of Contrastive Language-Image
Pre-training", Pattern Recognition, 2025. Written from the paper. Two operations:

Architecture surgery (the paper's section of that name). The similarity of CLIP's patches with a
text lights up the background. Its queries and keys relate unlike regions, and its feed-forward
layers push patches towards the class token. So a second stream starts where the last blocks begin,
gathers only what attention gives when queries and keys are the values themselves, and skips the
feed-forward layers. Patches are read from it; the class token, and the input of every block, stay
those of the original.

Feature surgery (the paper's section of that name). What a patch has in common with every text says
nothing about this one. That part is estimated with the empty text and taken away. It is the paper's
form for one text, and the one used here for many too, so that no phrase influences another.

Features are divided by their length over channels before they are compared, each token by its own;
dividing over tokens instead would weigh channels by how they vary over the picture.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import torch
from torch.nn.functional import normalize, scaled_dot_product_attention
from transformers import CLIPModel, CLIPProcessor

from w2c_grounding.evidence import heatmap_from_probabilities
from w2c_grounding.family import Evidence, RgbImage
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.pretrained import Remembered, load_model, load_processor
from w2c_grounding.wording import fill

SURGERY_BLOCKS = 6
"""How many of the last blocks get a second stream: half of the twelve of CLIP's base models, as the
paper has it."""

TEMPLATES = (
    "{}",
    "a photo of {}.",
    "a picture of {}.",
    "a close-up of {}.",
    "a view of {} in a room.",
    "a view of {} on a table.",
    "a bright photo of {}.",
    "a dark photo of {}.",
    "part of {} in a photo.",
    "there is {} in the scene.",
)
"""The mean of a phrase's embeddings in several sentences says less about the wording. The paper
takes 85 sentences written for the classes of ImageNet; these are for things about a robot."""


@dataclass(frozen=True)
class ClipSurgeryContext:
    """What is kept of a picture."""

    width: int
    height: int
    patches: torch.Tensor
    """(rows, columns, projection), each of length 1"""


class ClipSurgery:
    """A CLIP checkpoint in memory, asked by surgery. Thread-safe."""

    def __init__(
        self, model: Any, processor: Any, template: str, input_size: int | None = None
    ) -> None:
        # Any: transformers publishes no types for its model classes.
        self._model = model
        self._processor = processor
        self._templates = TEMPLATES if template == "{}" else (template,)
        self._side = input_size or int(model.config.vision_config.image_size)
        self._longest_text = int(model.config.text_config.max_position_embeddings)
        self._directions = Remembered[torch.Tensor]()
        with torch.inference_mode():
            self._empty = self._text("")

    @classmethod
    def load(cls, config: ModelConfig, source: str, template: str) -> Self:
        """Load from a directory or a hub id.

        Raises:
            ConfigError: the device does not exist here.
            ModelError: the files are missing, damaged, or of another architecture.
        """
        processor = load_processor(CLIPProcessor, config, source, backend="pil")
        model = load_model(CLIPModel, config, source)
        return cls(model, processor, template, config.input_size)

    @torch.inference_mode()
    def prepare(self, image: RgbImage) -> ClipSurgeryContext:
        """Run the picture tower once, with both streams.

        The whole picture is scaled to a square: cropping, as CLIP was trained, would lose its
        sides.
        """
        pixels = self._processor.image_processor(
            images=image,
            size={"height": self._side, "width": self._side},
            do_center_crop=False,
            return_tensors="pt",
        )["pixel_values"].to(self._model.device, self._model.dtype)
        tokens = normalize(surgery_tokens(self._model, pixels), dim=-1)[0, 1:]
        rows = self._side // int(self._model.config.vision_config.patch_size)
        grid = tokens.reshape(rows, rows, -1)
        return ClipSurgeryContext(image.shape[1], image.shape[0], grid)

    @torch.inference_mode()
    def query(self, context: ClipSurgeryContext, phrases: Sequence[str]) -> list[Evidence]:
        """Return, for each phrase, how well each patch fits it, scaled by how well the best does.

        The paper scales every map to [0, 1], so that something always fits. Here the map is
        multiplied by the probability that the best patch is nearer to the phrase than to the empty
        text, with CLIP's own temperature: 0.5 says that the phrase adds nothing.
        """
        directions = torch.stack(
            [self._directions.get(phrase, self._direction) for phrase in phrases]
        )
        similarities = (context.patches @ directions.T).float()  # (rows, columns, phrases)
        highest = similarities.amax(dim=(0, 1))
        lowest = similarities.amin(dim=(0, 1))
        presence = (highest * self._model.logit_scale.exp().float()).sigmoid()
        # A map without contrast is flat, not divided by nothing.
        contrast = (highest - lowest).clamp_min(torch.finfo(torch.float32).eps)
        heat = ((similarities - lowest) / contrast * presence).cpu().numpy()
        return [
            Evidence(heatmap_from_probabilities(heat[..., index], context.width, context.height))
            for index in range(len(phrases))
        ]

    def _direction(self, phrase: str) -> torch.Tensor:
        """Return what to compare patches with (projection,): the text less the empty one.

        f . t - f . t_empty = f . (t - t_empty): feature surgery for one text.
        """
        return self._text(phrase) - self._empty

    def _text(self, phrase: str) -> torch.Tensor:
        """Return the mean embedding (projection,) of a phrase in all sentences, of length 1."""
        tokens = self._processor.tokenizer(
            [fill(template, phrase) for template in self._templates],
            padding=True,
            truncation=True,
            max_length=self._longest_text,
            return_tensors="pt",
        ).to(self._model.device)
        features = self._model.get_text_features(
            input_ids=tokens["input_ids"], attention_mask=tokens["attention_mask"]
        ).pooler_output
        return normalize(normalize(features, dim=-1).mean(dim=0), dim=-1)


def surgery_tokens(model: Any, pixels: torch.Tensor) -> torch.Tensor:
    """Return projected features (batch, 1 + patches, projection), after architecture surgery.

    Token 0 is the class token, as `CLIPModel.get_image_features` gives it.
    """
    tower = model.vision_model
    blocks = tower.encoder.layers
    start = max(0, len(blocks) - SURGERY_BLOCKS)
    original = tower.pre_layrnorm(tower.embeddings(pixels, interpolate_pos_encoding=True))
    surgery = original
    for index, block in enumerate(blocks):
        if index == start:
            surgery = original
        if index >= start:
            surgery = surgery + value_attention(block.self_attn, block.layer_norm1(original))
        original = block(original, attention_mask=None)
    tokens = torch.cat([original[:, :1], surgery[:, 1:]], dim=1)
    projected: torch.Tensor = model.visual_projection(tower.post_layernorm(tokens))
    return projected


def value_attention(attention: Any, hidden: torch.Tensor) -> torch.Tensor:
    """Return softmax(v v^T / sqrt(d)) v, projected as the block would: architecture surgery.

    Args:
        attention: Of a block of CLIP.
        hidden: (batch, tokens, width), after the block's first layer norm.
    """
    values = attention.v_proj(hidden)
    heads = values.unflatten(-1, (attention.num_heads, attention.head_dim)).transpose(1, 2)
    mixed = scaled_dot_product_attention(heads, heads, heads)
    projected: torch.Tensor = attention.out_proj(mixed.transpose(1, 2).flatten(-2))
    return projected
