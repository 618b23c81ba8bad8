"""Which models are combined: a language model, a detector and a segmenter, each by name.

A name is one of a file of models (TOML: `[llm.NAME]` and `[vision.NAME]`, flags of `w2c llm` and
`w2c grounding`; `prompts` chooses the prompt set), `embedded`, a GGUF file or `openai:MODEL` for a
language model, and anything that `w2c grounding --model` takes for vision. `truth` is the folder's
own boxes and areas.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, Literal

import msgspec

from w2c.config import read_toml
from w2c.errors import ConfigError
from w2c_evaluation.embedded import checksum_of_embedded

EMBEDDED = "embedded"
OPENAI = "openai:"
PromptSetName = Literal["embedded", "large"]


@dataclass(frozen=True, eq=False)
class ModelSpec:
    """A model by name, and the flags of the service that runs it."""

    name: str
    flags: Mapping[str, Any]
    prompts: str = ""
    """Prompt set of a language model"""
    weights: str = ""
    """Checksum of an embedded model: its name stays when it is trained anew"""

    @property
    def digest(self) -> str:
        """Return a short text that is another one for other flags, or other embedded weights."""
        parts = [dict(self.flags), self.prompts, *([self.weights] if self.weights else [])]
        key = msgspec.json.encode(parts, order="sorted")
        return hashlib.blake2b(key, digest_size=6).hexdigest()


@dataclass(frozen=True)
class Combination:
    """One row of Table I."""

    llm: ModelSpec
    detector: ModelSpec
    segmenter: ModelSpec

    @property
    def names(self) -> tuple[str, str, str]:
        """Return the names of language model, detector and segmenter."""
        return self.llm.name, self.detector.name, self.segmenter.name

    @property
    def label(self) -> str:
        """Return the names in one line: `LLM + DETECTOR / SEGMENTER`, equal ones once."""
        llm, detector, segmenter = self.names
        vision = detector if detector == segmenter else f"{detector} / {segmenter}"
        return llm if llm == vision else f"{llm} + {vision}"

    @property
    def digest(self) -> str:
        """Return a text that is another one for other models or flags."""
        return "-".join((self.llm.digest, self.detector.digest, self.segmenter.digest))


class Catalogue:
    """The models of the files that were given."""

    def __init__(self, files: Sequence[Path]) -> None:
        """Read the files; a later one replaces names of an earlier one. Raises ConfigError."""
        self._llm: dict[str, dict[str, Any]] = {}
        self._vision: dict[str, dict[str, Any]] = {}
        for path in files:
            tables = read_toml(path)
            unknown = set(tables) - {"llm", "vision"}
            if unknown:
                raise ConfigError(
                    f"{path}: unknown tables {', '.join(sorted(unknown))}; a file of models has "
                    "[llm.NAME] and [vision.NAME]"
                )
            for kind, models in (("llm", self._llm), ("vision", self._vision)):
                for name, flags in tables.get(kind, {}).items():
                    if not isinstance(flags, dict):
                        raise ConfigError(f"{path}: [{kind}.{name}] is no table of flags")
                    models[name] = flags

    def language_model(self, name: str) -> ModelSpec:
        """Return a language model by name. Raises ConfigError."""
        if name in self._llm:
            flags = dict(self._llm[name])
            prompts = str(flags.pop("prompts", "large"))
            if prompts not in ("embedded", "large"):
                raise ConfigError(f"[llm.{name}]: prompts '{prompts}'; known: embedded, large")
            return ModelSpec(name, flags, prompts)
        if name == EMBEDDED:
            return ModelSpec(name, {}, "embedded", checksum_of_embedded("language_service"))
        if name.startswith(OPENAI):
            return ModelSpec(name, {"backend": "openai", "model": name[len(OPENAI) :]}, "large")
        if name.endswith(".gguf"):
            return ModelSpec(Path(name).stem, {"model": name}, "large")
        known = ", ".join((EMBEDDED, *self._llm))
        raise ConfigError(
            f"no language model '{name}'; known: {known}, a .gguf file, {OPENAI}MODEL, or a name "
            "of a file that --models gives"
        )

    def vision_model(self, name: str) -> ModelSpec:
        """Return a vision model by name; what is not in a file is a model of grounding."""
        if name in self._vision:
            return ModelSpec(name, dict(self._vision[name]))
        if name == EMBEDDED:
            return ModelSpec(name, {}, weights=checksum_of_embedded("grounding_service"))
        return ModelSpec(name, {"model": name})

    def combine(
        self, llms: Sequence[str], detectors: Sequence[str], segmenters: Sequence[str]
    ) -> list[Combination]:
        """Return every combination, those of one language model together. Raises ConfigError."""
        parts = (
            [self.language_model(name) for name in dict.fromkeys(llms)],
            [self.vision_model(name) for name in dict.fromkeys(detectors)],
            [self.vision_model(name) for name in dict.fromkeys(segmenters)],
        )
        return [Combination(*one) for one in product(*parts)]
