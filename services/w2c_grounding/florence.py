"""Florence-2 through transformers' own classes: boxes by phrase, or outlines by phrase.

Xiao et al., "Florence-2: Advancing a Unified Representation for a Variety of Vision Tasks", CVPR
2024. An image tower, and a language model that reads its features and writes places as words. The
checkpoints of `florence-community`; those of `microsoft` hold code of their own, which is not run.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Self

import torch
from transformers import (
    AutoProcessor,
    Florence2ForConditionalGeneration,
    LogitsProcessor,
    LogitsProcessorList,
)
from transformers.modeling_outputs import BaseModelOutput

from w2c.errors import ModelError
from w2c_grounding.adapters import heatmap_from_boxes, heatmap_from_polygons
from w2c_grounding.family import Evidence, RgbImage
from w2c_grounding.florence_answer import BINS, NEIGHBOURS, Location, boxes_of, polygons_of
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.pretrained import load_model, load_processor
from w2c_grounding.wording import fill

Task = Literal["boxes", "outlines"]

_PROMPTS: dict[Task, str] = {
    "boxes": "<OPEN_VOCABULARY_DETECTION>",
    "outlines": "<REFERRING_EXPRESSION_SEGMENTATION>",
}
_LONGEST: dict[Task, int] = {"boxes": 128, "outlines": 512}
"""Tokens of an answer: a score of boxes, or outlines of 200 corners"""

_LONGEST_PHRASE = 64
"""[tokens], with the words of the task"""

_AT_ONCE = 8
"""Phrases in one batch, which bounds memory"""


@dataclass(frozen=True)
class FlorenceContext:
    """The features of the image tower, as the language model reads them."""

    width: int
    height: int
    features: torch.Tensor
    """(1, tokens, hidden)"""


class _Witness(LogitsProcessor):
    """Notes at each step how certain each location is; changes nothing.

    The scores of all steps over the whole vocabulary would take hundreds of megabytes.
    """

    def __init__(self, locations: torch.Tensor) -> None:
        self._locations = locations
        self.certainties: list[torch.Tensor] = []
        """One a step, (batch, bins): the certainty of a bin and its neighbours together"""

    def __call__(
        self,
        input_ids: torch.Tensor,  # noqa: ARG002 - of the interface
        scores: torch.Tensor,
    ) -> torch.Tensor:
        """Return the scores (batch, vocabulary) as they are."""
        probabilities = scores.float().softmax(dim=-1)[:, self._locations]
        sums = torch.nn.functional.pad(probabilities.cumsum(dim=-1), (NEIGHBOURS + 1, NEIGHBOURS))
        sums[:, -NEIGHBOURS:] = sums[:, -NEIGHBOURS - 1 : -NEIGHBOURS]
        self.certainties.append(sums[:, 2 * NEIGHBOURS + 1 :] - sums[:, : -2 * NEIGHBOURS - 1])
        return scores


class Florence:
    """A Florence-2 checkpoint in memory. One thread at a time."""

    def __init__(self, model: Any, processor: Any, template: str, task: Task) -> None:
        # Any: transformers publishes no types for its model classes.
        self._model = model.eval()
        self._processor = processor
        self._template = template
        self._task: Task = task
        tokenizer = processor.tokenizer
        ids = tokenizer.convert_tokens_to_ids([f"<loc_{index}>" for index in range(BINS)])
        self._bins = {token: index for index, token in enumerate(ids)}
        if len(self._bins) != BINS or tokenizer.unk_token_id in self._bins:
            raise ModelError(
                f"the tokenizer has {len(self._bins)} of {BINS} location tokens: this is no "
                "Florence-2 checkpoint, or its tokenizer files are of another model"
            )
        self._locations = torch.tensor(ids, device=model.device)

    @classmethod
    def load(cls, config: ModelConfig, source: str, template: str, task: Task) -> Self:
        """Load from a directory or a hub id.

        Raises:
            ConfigError: the device does not exist here.
            ModelError: the files are missing, damaged, or of another architecture.
        """
        processor = load_processor(AutoProcessor, config, source, backend="pil")
        model = load_model(Florence2ForConditionalGeneration, config, source)
        return cls(model, processor, template, task)

    @torch.inference_mode()
    def prepare(self, image: RgbImage) -> FlorenceContext:
        """Run the image tower once."""
        inputs = self._processor.image_processor(images=image, return_tensors="pt")
        pixels = inputs["pixel_values"].to(self._model.device, self._model.dtype)
        features = self._model.get_image_features(pixel_values=pixels).pooler_output
        return FlorenceContext(image.shape[1], image.shape[0], features)

    def query(self, context: FlorenceContext, phrases: Sequence[str]) -> list[Evidence]:
        """Let the language model write the places of each phrase."""
        batches = [phrases[at : at + _AT_ONCE] for at in range(0, len(phrases), _AT_ONCE)]
        return [one for batch in batches for one in self._answer(context, batch)]

    @torch.inference_mode()
    def _answer(self, context: FlorenceContext, phrases: Sequence[str]) -> list[Evidence]:
        encoded, mask = self._read(context, phrases)
        witness = _Witness(self._locations)
        written = self._model.generate(
            encoder_outputs=encoded,
            attention_mask=mask,
            logits_processor=LogitsProcessorList([witness]),
            max_new_tokens=_LONGEST[self._task],
            # Beams take a fifth more time, and what they find has no certainty per token.
            num_beams=1,
            do_sample=False,
        )
        # The first token is where the decoder starts; each later one has a step of the witness.
        tokens = written[:, 1:].cpu().tolist()
        certainties = torch.stack(witness.certainties, dim=1).cpu()  # (batch, steps, bins)
        return [
            self._evidence(context, [self._location(token, step) for token, step in answer])
            for answer in (
                list(zip(row, steps, strict=True))
                for row, steps in zip(tokens, certainties, strict=True)
            )
        ]

    def _read(
        self, context: FlorenceContext, phrases: Sequence[str]
    ) -> tuple[BaseModelOutput, torch.Tensor]:
        """Return what the encoder makes of picture and phrases, and which of it is no padding."""
        tokenizer = self._processor.tokenizer
        prompts = [_PROMPTS[self._task] + fill(self._template, phrase) for phrase in phrases]
        # The processor writes the task out in words; with a picture it would prepare that again.
        words = self._processor(text=prompts, truncation=True, max_length=_LONGEST_PHRASE)
        rows = [
            [tokenizer.bos_token_id, *row, tokenizer.eos_token_id] for row in words["input_ids"]
        ]
        padded = tokenizer.pad({"input_ids": rows}, return_tensors="pt").to(self._model.device)
        embedded = self._model.get_input_embeddings()(padded["input_ids"])
        seen = context.features.to(embedded.dtype).expand(len(phrases), -1, -1)
        inputs = torch.cat([seen, embedded], dim=1)
        mask = torch.cat(
            [padded["attention_mask"].new_ones(seen.shape[:2]), padded["attention_mask"]], dim=1
        )
        encoded = self._model.get_encoder()(inputs_embeds=inputs, attention_mask=mask)
        return BaseModelOutput(last_hidden_state=encoded.last_hidden_state), mask

    def _location(self, token: int, certainties: torch.Tensor) -> Location | None:
        found = self._bins.get(token)
        return None if found is None else Location(found, float(certainties[found]))

    def _evidence(self, context: FlorenceContext, tokens: list[Location | None]) -> Evidence:
        width, height = context.width, context.height
        if self._task == "boxes":
            boxes = boxes_of(tokens, width, height)
            return Evidence(heatmap_from_boxes(boxes, width, height), boxes)
        polygons, scores = polygons_of(tokens, width, height)
        return Evidence(heatmap_from_polygons(polygons, scores, width, height))
