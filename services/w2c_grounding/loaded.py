"""A model in memory with all that belongs to it, and how another one is chosen."""

import gc
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import msgspec
import numpy as np

from w2c.errors import ModelError, W2CError
from w2c.messages import GroundingReply, GroundingRequest
from w2c_grounding.answer import Grounder
from w2c_grounding.card import ModelCard
from w2c_grounding.evidence import PointRule
from w2c_grounding.family import Family
from w2c_grounding.guard import Guarded, release
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.picture import encode_png
from w2c_grounding.registry import EMBEDDED_NAME
from w2c_grounding.timed import TimedFamily

Load = Callable[[ModelConfig], tuple[Family[Any], ModelCard]]


@runtime_checkable
class Remote(Protocol):
    """A family with more to it than memory: one that asks a model elsewhere."""

    def warm_up(self) -> None:
        """Do once what makes the first answer slow, and nothing that costs money."""

    def close(self) -> None:
        """Close connections. Idempotent."""


@dataclass(frozen=True)
class LoadedModel:
    """One model that is ready to answer."""

    card: ModelCard
    model: Family[Any]
    family: TimedFamily
    """The model, as the grounder asks it"""
    grounder: Grounder

    def close(self) -> None:
        """Let go of what the model holds beside memory. Idempotent."""
        if isinstance(self.model, Remote):
            self.model.close()


def load_model(
    load: Load, config: ModelConfig, rule: PointRule, timer: Callable[[], int]
) -> LoadedModel:
    """Load a model and let it answer once: the first answer chooses kernels, and takes longer.

    Args:
        load: `registry.load`, or a test's own.
        config: Which model.
        rule: How the point is chosen.
        timer: Returns the time [ns].

    Raises:
        ConfigError: a value makes no sense here.
        ModelError: the model cannot be loaded, or cannot answer.
    """
    found, card = load(config)
    family = TimedFamily(found, timer)
    own = found.family if isinstance(found, Guarded) else found
    model = LoadedModel(card, own, family, Grounder(family, card, rule, timer))
    if isinstance(own, Remote):
        own.warm_up()
    else:
        blank = encode_png(np.full((720, 1280, 3), 128, dtype=np.uint8))
        request = GroundingRequest(jpeg=blank, phrases=["warm up"], want="heatmaps")
        first_answer(card.name, model.grounder, request)
    family.take()
    return model


def first_answer(name: str, grounder: Grounder, request: GroundingRequest) -> GroundingReply:
    """Return a model's answer to the first request that it gets.

    Args:
        name: Of the model.
        grounder: Asks it.
        request: The first one.

    Raises:
        RefusedError: the picture or a phrase cannot be asked about, or memory ran out.
        ModelError: the model was loaded and cannot answer.
    """
    try:
        return grounder.ground(request)
    except W2CError:
        raise
    # A size or a precision that the model's own layers do not take: each says so in its own way.
    except Exception as error:
        raise ModelError(
            f"{name} was loaded and cannot answer: {type(error).__name__}: {error}; leave "
            "--input-size out or choose a larger one, try --dtype float32, or name another --model"
        ) from error


def another(config: ModelConfig, model: str, family: str) -> ModelConfig:
    """Return the configuration of another model on the same machine.

    Device, precision, threads and leave to download stay; what was set for the old model itself
    (revision, size, threshold, template) does not hold for the new one.

    Args:
        config: Of the process.
        model: As `--model` takes it, or `EMBEDDED_NAME`.
        family: As `--family` takes it; empty = what the checkpoint says of itself.
    """
    return msgspec.structs.replace(
        config,
        model="" if model == EMBEDDED_NAME else model,
        family=family,
        revision="",
        input_size=None,
        threshold=None,
        template=None,
    )


def give_memory_back(device: str) -> None:
    """Free what a model left behind, here and on its device."""
    gc.collect()
    release(device)
