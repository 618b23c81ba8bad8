"""A vision-language model in this process, through the chat template of its checkpoint."""

import threading
from typing import Any, Self

import numpy as np
import torch
from transformers import AutoModelForImageTextToText, AutoProcessor

from w2c.errors import ModelError
from w2c_grounding.family import RgbImage
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.pointer.options import PointerOptions
from w2c_grounding.pointer.server import shrunk
from w2c_grounding.pointer.talker import Shown, Turn
from w2c_grounding.pretrained import load_model, load_processor
from w2c_grounding.torchvision_build import need_torchvision


class LocalTalker:
    """A checkpoint in memory. One thread at a time."""

    def __init__(self, model: Any, processor: Any, options: PointerOptions) -> None:
        # Any: transformers publishes no types for its model classes.
        self._model = model
        self._processor = processor
        self._options = options
        self._turn = threading.Lock()

    @classmethod
    def load(cls, config: ModelConfig, source: str, options: PointerOptions) -> Self:
        """Load from a directory or a hub id.

        Raises:
            ConfigError: the device does not exist here, or torchvision is missing.
            ModelError: the files are missing or damaged, or hold no chat template.
        """
        try:
            processor = load_processor(AutoProcessor, config, source)
        except ModelError as error:
            if "torchvision" in str(error).lower():
                need_torchvision(f"the checkpoint '{source}'")
            raise
        if not getattr(processor, "chat_template", None):
            raise ModelError(
                f"'{source}' has no chat template: it cannot be asked in words; use a checkpoint "
                "that was trained to talk, such as an Instruct one"
            )
        return cls(load_model(AutoModelForImageTextToText, config, source), processor, options)

    @property
    def at_once(self) -> int:
        """How many threads may ask at once."""
        return 1

    def show(self, image: RgbImage) -> Shown:
        """Return the picture, shrunk where it is larger than wanted."""
        picture = shrunk(image, self._options.longest_side)
        return Shown(picture.width, picture.height, picture)

    def ask(self, shown: Shown, turns: list[Turn]) -> str:
        """Return the answer to the last turn."""
        messages: list[dict[str, Any]] = [
            {"role": turn.role, "content": [{"type": "text", "text": turn.text}]} for turn in turns
        ]
        messages[0]["content"].insert(0, {"type": "image"})
        text = self._processor.apply_chat_template(messages, add_generation_prompt=True)
        inputs = self._processor(text=text, images=[shown.picture], return_tensors="pt")
        inputs = inputs.to(self._model.device, self._model.dtype)
        with self._turn, torch.inference_mode():
            written = self._model.generate(
                **inputs, max_new_tokens=self._options.max_tokens, do_sample=False
            )
        answer = written[:, inputs["input_ids"].shape[1] :]
        return str(self._processor.batch_decode(answer, skip_special_tokens=True)[0])

    def warm_up(self) -> None:
        """Let the model answer once."""
        grey = self.show(np.full((72, 128, 3), 128, dtype=np.uint8))
        self.ask(grey, [Turn("user", "Is this a cup?")])

    def close(self) -> None:
        """Do nothing: its memory is freed with it."""
