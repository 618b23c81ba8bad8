"""A small GroundingDINO that learnt coloured shapes, for the tests of what its boxes mean.

It takes nine minutes of one core, too long for a test, so tests/data/shapes_dino holds the result.
At a rate of 2e-3, and with 6 pictures a step at 1e-3, boxes did not get beyond half of the overlap.

    PYTHONPATH=tests .venv/bin/python -m fakes.learned_dino tests/data/shapes_dino
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import torch

from fakes.shapes import COLOURS, PHRASES, SHAPES, SIDE, Shapes, draw_shapes
from fakes.tiny_models import tiny_grounding_dino

STEPS = 6000
BATCH = 8
RATE = 1.2e-3
PRESENT_SHARE = 0.75


def learned_grounding_dino(directory: Path, steps: int = STEPS, seed: int = 1) -> Path:
    """Train a GroundingDINO on shapes, and write it as a checkpoint; return its directory."""
    from transformers import AutoModelForZeroShotObjectDetection, GroundingDinoProcessor

    torch.set_num_threads(1)  # sums of another order end elsewhere
    tiny_grounding_dino(directory, words=(*COLOURS, *SHAPES), seed=5)
    processor: Any = GroundingDinoProcessor.from_pretrained(directory, backend="pil")
    model: Any = AutoModelForZeroShotObjectDetection.from_pretrained(directory).train()
    images = processor.image_processor
    mean, deviation = (
        torch.tensor(values).view(1, 3, 1, 1) for values in (images.image_mean, images.image_std)
    )
    tokens = {text: processor.tokenizer(f"{text}.", return_tensors="pt") for text in PHRASES}
    optimizer = torch.optim.AdamW(model.parameters(), lr=RATE, weight_decay=1e-4)
    rng = np.random.default_rng(seed)
    for step in range(steps):
        pictures = [draw_shapes(rng) for _ in range(BATCH)]
        texts = [_phrase(one, rng) for one in pictures]
        pixels = torch.from_numpy(np.stack([one.pixels for one in pictures])).permute(0, 3, 1, 2)
        for group in optimizer.param_groups:
            group["lr"] = RATE * min(1.0, (step + 1) / 50) * _falling(step / steps)
        output = model(
            pixel_values=(pixels.float() / 255.0 - mean) / deviation,
            pixel_mask=torch.ones(BATCH, SIDE, SIDE, dtype=torch.long),
            labels=[_label(one, text) for one, text in zip(pictures, texts, strict=True)],
            **{
                name: torch.cat([tokens[text][name] for text in texts]) for name in tokens[texts[0]]
            },
        )
        optimizer.zero_grad()
        torch.autograd.backward(output.loss)
        torch.nn.utils.clip_grad_norm_(model.parameters(), 0.5)
        optimizer.step()
    model.eval().half().save_pretrained(directory)
    # safetensors makes its file readable by its owner only.
    (directory / "model.safetensors").chmod(0o644)
    return directory


def _falling(fraction: float) -> float:
    return max(0.02, min(1.0, 2.5 * (1.0 - fraction)))


def _phrase(shapes: Shapes, rng: np.random.Generator) -> str:
    """Return what to ask for: mostly something that is there."""
    offers = sorted(shapes.masks) if rng.random() < PRESENT_SHARE else PHRASES
    return str(rng.choice(offers))


def _label(shapes: Shapes, text: str) -> dict[str, torch.Tensor]:
    """Return the box of a phrase as the model's loss takes it: centre and size, 0 to 1."""
    if text not in shapes.masks:
        return {"class_labels": torch.zeros(0, dtype=torch.long), "boxes": torch.zeros(0, 4)}
    left, top, right, bottom = (edge / SIDE for edge in shapes.edges(text))
    box = [(left + right) / 2, (top + bottom) / 2, right - left, bottom - top]
    return {"class_labels": torch.tensor([0]), "boxes": torch.tensor([box], dtype=torch.float32)}


if __name__ == "__main__":
    learned_grounding_dino(Path(sys.argv[1]))
