"""Pictures of coloured shapes, and a vision model that learnt in seconds to tell them apart."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import torch

from w2c_grounding.card import ModelCard
from w2c_grounding.train.augment import normalise
from w2c_grounding.train.loss import mask_loss
from w2c_grounding.train.model import Size, decode, embed, features, new_model, new_processor, save
from w2c_grounding.train.optimizer import Optimizer
from w2c_grounding.train.start import start_tower

COLOURS = {"red": (200, 40, 40), "green": (40, 170, 60), "blue": (50, 70, 210)}
SHAPES = ("square", "ring")
PHRASES = tuple(f"{colour} {shape}" for colour in COLOURS for shape in SHAPES)
SIDE = 64
SIZE = Size(
    image=SIDE,
    patch=8,
    width=64,
    layers=3,
    heads=4,
    extract=(1, 2),
    text_width=32,
    text_layers=1,
    projection=32,
    reduced=32,
)
STEPS = 300
BATCH = 24


@dataclass(frozen=True)
class Shapes:
    """A picture with two to four different things in it."""

    pixels: npt.NDArray[np.uint8]
    """(SIDE, SIDE, 3)"""
    masks: dict[str, npt.NDArray[np.bool_]]
    """Phrase -> (SIDE, SIDE), of what is there"""

    def edges(self, phrase: str) -> tuple[int, int, int, int]:
        """Return left, top, right and bottom of a thing [px]."""
        rows, columns = np.nonzero(self.masks[phrase])
        return int(columns.min()), int(rows.min()), int(columns.max()) + 1, int(rows.max()) + 1


def draw_shapes(rng: np.random.Generator) -> Shapes:
    """Draw things that do not touch each other, on a plain ground."""
    pixels = np.full((SIDE, SIDE, 3), rng.integers(110, 230), np.uint8)
    masks = {}
    places = [(row, column) for row in (16, 48) for column in (16, 48)]
    chosen = rng.choice(len(PHRASES), size=int(rng.integers(2, 5)), replace=False)
    for place, index in zip(rng.permutation(places), chosen, strict=False):
        phrase = PHRASES[index]
        colour, shape = phrase.split()
        radius = int(rng.integers(8, 13))
        row, column = (int(value) + int(rng.integers(-3, 4)) for value in place)
        drawn = np.zeros((SIDE, SIDE), np.uint8)
        if shape == "ring":
            cv2.circle(drawn, (column, row), radius, 1, 4)
        else:
            corner = (column - radius, row - radius)
            cv2.rectangle(drawn, corner, (column + radius, row + radius), 1, -1)
        masks[phrase] = drawn.astype(bool)
        shade = np.array(COLOURS[colour]) + rng.integers(-25, 26, 3)
        pixels[masks[phrase]] = shade.clip(0, 255)
    noisy = pixels + rng.normal(0.0, 6.0, pixels.shape)
    return Shapes(noisy.clip(0, 255).astype(np.uint8), masks)


def learned_clipseg(directory: Path, seed: int = 1) -> Path:
    """Train a CLIPSeg on shapes, and write it as a checkpoint; return its directory."""
    # Sums in another order teach it otherwise; so it learns the same in whatever process it is.
    torch.set_num_threads(1)
    rng = np.random.default_rng(seed)
    torch.manual_seed(seed)
    processor = new_processor(SIZE, [*COLOURS, *SHAPES])
    model = new_model(SIZE, len(processor.tokenizer)).train()
    start_tower(model, SIZE, _tensor([draw_shapes(rng) for _ in range(32)]))
    optimizer = Optimizer(list(model.named_parameters()), weight_decay=0.01)
    for step in range(STEPS):
        pictures = [draw_shapes(rng) for _ in range(BATCH)]
        asked = [[str(text) for text in rng.choice(PHRASES, 3, replace=False)] for _ in pictures]
        phrases = [text for texts in asked for text in texts]
        tokens = processor.tokenizer(phrases, padding=True, return_tensors="pt")
        seen = features(model, _tensor(pictures))
        logits = decode(model, seen, embed(model, tokens), (step % 2, step // 2 % 2), 2)
        nothing = np.zeros((SIDE, SIDE), bool)
        masks = [
            one.masks.get(text, nothing)
            for one, texts in zip(pictures, asked, strict=True)
            for text in texts
        ]
        wanted = torch.from_numpy(np.stack(masks)).float()[:, step % 2 :: 2, step // 2 % 2 :: 2]
        loss = mask_loss(logits, wanted, torch.ones(len(wanted)))
        torch.autograd.backward(loss)
        torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
        optimizer.step(3e-3 * min(1.0, (step + 1) / 20, 3.0 * (1.0 - step / STEPS)))
    card = ModelCard(name="shapes", threshold=0.5, vocabulary=sorted([*COLOURS, *SHAPES]))
    save(model.eval(), processor, card, directory)
    return directory


def _tensor(pictures: list[Shapes]) -> torch.Tensor:
    pixels = torch.from_numpy(np.stack([one.pixels for one in pictures]))
    return normalise(pixels.permute(0, 3, 1, 2).float() / 255.0)
