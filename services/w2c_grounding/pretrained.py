"""Weights and pre-processing from a directory or the hub: the public `from_pretrained` path.

Everything that families do alike lives here, so that each says the same thing when it fails.
"""

import errno
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Generic, TypeVar

import torch
from huggingface_hub import errors as hub
from huggingface_hub.utils import enable_progress_bars  # type: ignore[attr-defined]
from transformers.utils import logging as transformers_logging

from w2c.errors import ConfigError, ModelError
from w2c_grounding.guard import is_out_of_memory
from w2c_grounding.model_config import Dtype, ModelConfig

DTYPES: dict[Dtype, torch.dtype] = {
    "float32": torch.float32,
    "bfloat16": torch.bfloat16,
    "float16": torch.float16,
}

Value = TypeVar("Value")

_REMEMBERED_PHRASES = 1000
"""Phrases of a session repeat; an embedding is a few kilobytes, so this bounds memory to a few
megabytes."""


def where(config: ModelConfig) -> dict[str, Any]:
    """Return the arguments of every `from_pretrained`: offline unless told otherwise."""
    arguments: dict[str, Any] = {"local_files_only": not config.allow_download}
    if config.revision:
        arguments["revision"] = config.revision
    return arguments


def load_processor(kind: Any, config: ModelConfig, source: str, **options: Any) -> Any:
    """Return `kind.from_pretrained(source)`: a processor, which is text and picture preparation.

    Raises:
        ModelError: the files are missing, damaged, or of another kind.
    """
    _show_progress_of_downloads_only(config)
    with _explained(kind.__name__, source, config):
        return kind.from_pretrained(source, **where(config), **options)


def load_model(kind: Any, config: ModelConfig, source: str, **options: Any) -> Any:
    """Return `kind.from_pretrained(source)` on the device of the configuration, ready to answer.

    Raises:
        ConfigError: the device does not exist here.
        ModelError: the files are missing, damaged, or lack weights. transformers only warns of the
            last, and answers with random numbers in their place.
    """
    torch.set_num_threads(config.threads)
    _show_progress_of_downloads_only(config)
    with _explained(kind.__name__, source, config):
        model, report = kind.from_pretrained(
            source, dtype=DTYPES[config.dtype], output_loading_info=True, **where(config), **options
        )
    missing = sorted(report["missing_keys"])
    if missing:
        raise ModelError(
            f"the checkpoint '{source}' lacks {len(missing)} weights of {kind.__name__}, such as "
            f"{missing[0]}: it is damaged, or of another architecture. Copy the whole directory, "
            "or name another --model"
        )
    return to_device(model, config)


def to_device(model: Any, config: ModelConfig) -> Any:
    """Return the model on the device of the configuration. Raises ConfigError."""
    try:
        return model.to(config.device).eval()
    except (RuntimeError, AssertionError) as error:
        advice = "try --device cpu"
        if isinstance(error, torch.OutOfMemoryError):
            advice = "its memory is full: try --dtype bfloat16, a smaller model, or --device cpu"
        raise ConfigError(
            f"device '{config.device}' cannot be used: {_first_line(error)}; {advice}"
        ) from error


def model_type(config: ModelConfig, source: str) -> str:
    """Return what config.json calls the architecture of a hub id; empty where it does not say.

    Raises:
        ModelError: the file is not here and cannot be fetched.
    """
    from transformers import PretrainedConfig

    with _explained("configuration", source, config):
        values, _ = PretrainedConfig.get_config_dict(source, **where(config))
    return str(values.get("model_type", ""))


class Remembered(Generic[Value]):
    """What was computed of the latest phrases. Thread-safe."""

    def __init__(self, limit: int = _REMEMBERED_PHRASES) -> None:
        self._limit = limit
        self._values: OrderedDict[str, Value] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, phrase: str, compute: Callable[[str], Value]) -> Value:
        """Return the value of a phrase, computed now where it is not known."""
        with self._lock:
            if phrase in self._values:
                self._values.move_to_end(phrase)
                return self._values[phrase]
        value = compute(phrase)
        with self._lock:
            self._values[phrase] = value
            while len(self._values) > self._limit:
                self._values.popitem(last=False)
        return value

    def get_all(
        self, phrases: Sequence[str], compute: Callable[[list[str]], Sequence[Value]]
    ) -> list[Value]:
        """Return the value of each phrase; those that are not known are computed in one go."""
        with self._lock:
            new = [phrase for phrase in dict.fromkeys(phrases) if phrase not in self._values]
        computed = dict(zip(new, compute(new), strict=True)) if new else {}
        return [
            self.get(phrase, lambda phrase: computed[phrase])
            if phrase in computed
            else self.get(phrase, lambda phrase: compute([phrase])[0])
            for phrase in phrases
        ]


def _show_progress_of_downloads_only(config: ModelConfig) -> None:
    """Reading weights from disk takes a second, and a bar in a log helps nobody."""
    transformers_logging.disable_progress_bar()  # type: ignore[no-untyped-call]
    if config.allow_download:
        enable_progress_bars()


@contextmanager
def _explained(what: str, source: str, config: ModelConfig) -> Iterator[None]:
    """Turn whatever loading raises into a ModelError with the next step.

    transformers, safetensors, the tokenizers and the hub each have errors of their own.
    """
    try:
        yield
    except ModelError:
        raise
    except Exception as error:
        raise ModelError(
            f"{what} of '{source}' cannot be loaded: {_first_line(error)}. "
            f"{_lack(error) or _next_step(error, source, config)}"
        ) from error


def _lack(error: BaseException) -> str:
    """Return what to do where disk or memory is full; "" where neither is."""
    causes = tuple(_causes(error))
    if any(getattr(cause, "errno", None) in (errno.ENOSPC, errno.EDQUOT) for cause in causes):
        return "The disk is full: free some space and begin again; what was fetched is kept"
    if any(is_out_of_memory(cause) for cause in causes):
        return "Memory is full: end other programs, try --dtype bfloat16, or a smaller --model"
    return ""


def _next_step(error: BaseException, source: str, config: ModelConfig) -> str:
    """Return what to do about it, from what caused the error."""
    causes = tuple(_causes(error))

    def caused_by(*kinds: type[BaseException]) -> bool:
        return any(isinstance(cause, kinds) for cause in causes)

    if caused_by(hub.GatedRepoError):
        return (
            f"Its owner asks for consent: accept the terms at https://huggingface.co/{source}, "
            "then log in with: hf auth login"
        )
    if caused_by(hub.RevisionNotFoundError):
        return "The hub has no such --revision; leave it empty for the newest"
    if caused_by(hub.RepositoryNotFoundError):
        return "The hub has no such model, or it is private; check --model"
    if not config.allow_download:
        return (
            "It is not, or not wholly, on this machine: give a checkpoint directory, or fetch the "
            "hub id with --allow-download"
        )
    if caused_by(hub.LocalEntryNotFoundError, hub.HfHubHTTPError, ConnectionError):
        return (
            "The hub did not answer. Without a network: fetch it elsewhere with "
            f"'hf download {source} --local-dir DIR', copy DIR, and give --model DIR"
        )
    return "Its files are damaged or of another architecture: fetch it again, or check --family"


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def _first_line(error: BaseException) -> str:
    text = str(error).strip()
    return text.splitlines()[0][:300] if text else type(error).__name__
