"""Time and memory of one model, measured in the process that calls.

Every round asks each kind of question once, in an order that turns, so that whatever slows the
machine slows all of them. Pictures and phrases are new each time: what is remembered of others
does not help.
"""

import io
import resource
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import msgspec
import numpy as np
from PIL import Image, ImageDraw

from w2c.messages import GroundingRequest
from w2c_grounding.card import ModelCard
from w2c_grounding.evidence import PointRule
from w2c_grounding.family import Family
from w2c_grounding.loaded import load_model
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import EMBEDDED_NAME
from w2c_grounding.registry import load as load_registered

SIZE = (1280, 720)
"""Of the pictures [px]: the camera's"""

SEVERAL = 5
"""Phrases on one picture, and pictures in a row"""

_RULE: PointRule = "interior"

_COLOURS = ("red", "blue", "green", "white", "black", "brown", "grey", "yellow")
_MATERIALS = ("wooden", "metal", "plastic", "glass", "paper", "small", "large", "round")
_THINGS = ("book", "cup", "box", "table", "kettle", "drawer", "ladder", "wall", "chair", "plate")

Load = Callable[[ModelConfig], tuple[Family[Any], ModelCard]]


class Question(msgspec.Struct, frozen=True, kw_only=True):
    """Which model is measured, and how."""

    model: str
    """As `--model` takes it, or `embedded`"""
    family: str = ""
    device: str = "cpu"
    dtype: str = "float32"
    threads: int = 2
    rounds: int = 20
    seed: int = 0


@dataclass
class Spent:
    """Times of one kind of question, one value a round [ms]."""

    wall_ms: list[float] = field(default_factory=list)
    cpu_ms: list[float] = field(default_factory=list)
    """Of all threads of the process: what else runs on the machine does not count"""


@dataclass(frozen=True)
class Costs:
    """What a model costs."""

    name: str
    device: str
    load_s: float
    """Weights from disk, and the first answer"""
    spent: dict[str, Spent]
    """By question: `one_phrase`, `five_phrases`, `five_images`, `known_picture`"""
    memory_mb: float
    """Of the process once the model is loaded"""
    peak_memory_mb: float
    """Highest so far; of this model alone where the process is new"""
    peak_device_mb: float | None
    """Of a GPU; None on a CPU"""


def measure(question: Question, load: Load = load_registered) -> Costs | None:
    """Return what a model costs; None where this machine has no such device.

    Raises:
        ConfigError: a value makes no sense here.
        ModelError: the model cannot be loaded.
    """
    if not _has_device(question.device):
        return None
    config = msgspec.convert(
        {
            "model": "" if question.model == EMBEDDED_NAME else question.model,
            "family": question.family,
            "device": question.device,
            "dtype": question.dtype,
            "threads": question.threads,
        },
        ModelConfig,
    )
    started = time.perf_counter()
    model = load_model(load, config, _RULE, time.monotonic_ns)
    load_s = time.perf_counter() - started
    memory_mb = _memory_mb()
    generator = np.random.default_rng(question.seed)
    pictures, phrases = new_pictures(generator), new_phrases(generator)

    def ask(picture: bytes, count: int) -> None:
        wanted = list(islice(phrases, count))
        model.grounder.ground(GroundingRequest(jpeg=picture, phrases=wanted, want="boxes"))

    known = next(pictures)
    kinds: dict[str, tuple[int, int]] = {
        "one_phrase": (1, 1),
        "five_phrases": (1, SEVERAL),
        "five_images": (SEVERAL, 1),
        "known_picture": (0, 1),
    }
    spent = {name: Spent() for name in kinds}
    order = list(kinds)
    for _ in range(question.rounds):
        for name in order:
            images, count = kinds[name]
            shown = list(islice(pictures, images)) or [known]
            if not images:
                ask(known, 1)  # the pictures between made it forget this one
            wall, cpu = time.perf_counter(), time.process_time()
            for picture in shown:
                ask(picture, count)
            spent[name].cpu_ms.append(1e3 * (time.process_time() - cpu))
            spent[name].wall_ms.append(1e3 * (time.perf_counter() - wall))
        order.append(order.pop(0))
    return Costs(
        model.card.name,
        question.device,
        load_s,
        spent,
        memory_mb,
        resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6,  # of KiB
        _peak_device_mb(question.device),
    )


def costs_of(**question: Any) -> Costs | None:
    """Return what a model costs, asked by the names of `Question`. See `measure`."""
    return measure(msgspec.convert(question, Question))


def new_pictures(generator: np.random.Generator) -> Iterator[bytes]:
    """Yield JPEGs of coloured boxes before a slope of grey, none like another."""
    across, down = SIZE
    slope = np.linspace(60, 200, across)[np.newaxis, :] + np.linspace(-20, 20, down)[:, np.newaxis]
    while True:
        coarse = generator.normal(0.0, 6.0, (down // 4, across // 4, 3))
        grain = coarse.repeat(4, axis=0).repeat(4, axis=1)
        ground = np.clip(slope[:, :, np.newaxis] + grain, 0, 255).astype(np.uint8)
        picture = Image.fromarray(ground)
        draw = ImageDraw.Draw(picture)
        for _ in range(8):
            left, top = (int(generator.integers(0, side - 100)) for side in SIZE)
            width, height = (int(size) for size in generator.integers(40, 300, 2))
            colour = tuple(int(value) for value in generator.integers(0, 256, 3))
            draw.rectangle((left, top, left + width, top + height), fill=colour)
        buffer = io.BytesIO()
        picture.save(buffer, format="JPEG", quality=90)
        yield buffer.getvalue()


def new_phrases(generator: np.random.Generator) -> Iterator[str]:
    """Yield phrases of three words, none of them twice until all were used."""
    while True:
        for index in generator.permutation(len(_COLOURS) * len(_MATERIALS) * len(_THINGS)):
            rest, thing = divmod(int(index), len(_THINGS))
            colour, material = divmod(rest, len(_MATERIALS))
            yield f"the {_COLOURS[colour]} {_MATERIALS[material]} {_THINGS[thing]}"


def _has_device(device: str) -> bool:
    if not device.startswith("cuda"):
        return True
    import torch

    return torch.cuda.is_available()


def _peak_device_mb(device: str) -> float | None:
    if not device.startswith("cuda"):
        return None
    return float(sys.modules["torch"].cuda.max_memory_allocated(device)) / 1e6


def _memory_mb() -> float:
    import psutil

    return float(psutil.Process().memory_info().rss) / 1e6
