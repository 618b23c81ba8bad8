"""Public models by name, from `models.toml`: what they are, whose licence, and how to ask them."""

import tomllib
from pathlib import Path
from typing import Annotated

import msgspec

from w2c_grounding.model_config import ModelConfig
from w2c_grounding.wording import check_template

FILE = Path(__file__).with_name("models.toml")


class KnownModel(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A row of `models.toml`."""

    name: Annotated[str, msgspec.Meta(pattern="^[a-z0-9.-]+$", max_length=40)]
    family: str
    model: str
    """Hub id"""
    gives: str
    """What it answers with, for people"""
    licence: str
    licence_source: str
    """Where that was read; "not checked" = from memory: read the model's page before relying on
    it"""
    revision: str = ""
    template: str | None = None
    threshold: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] | None = None
    input_size: int | None = None
    megabytes: int | None = None
    """Of the weights, which is what a download takes; None = not known"""

    def applied_to(self, config: ModelConfig) -> ModelConfig:
        """Return the configuration with this model's values where it has none of its own."""
        return msgspec.structs.replace(
            config,
            family=config.family or self.family,
            model=self.model,
            revision=config.revision or self.revision,
            template=self.template if config.template is None else config.template,
            threshold=self.threshold if config.threshold is None else config.threshold,
            input_size=self.input_size if config.input_size is None else config.input_size,
        )


class _Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    model: list[KnownModel]


def read_known(path: Path) -> dict[str, KnownModel]:
    """Return the known models by name. Raises ValueError for a table that is none."""
    table = msgspec.convert(tomllib.loads(path.read_text(encoding="utf-8")), _Table)
    known = {model.name: model for model in table.model}
    if len(known) != len(table.model):
        raise ValueError(f"{path} gives a name twice; every [[model]] needs its own")
    for model in table.model:
        if model.template is not None:
            check_template(model.template)
    return known


KNOWN = read_known(FILE)
