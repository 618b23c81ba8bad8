"""Which model to load, and from where; the configuration may set its own threshold and template."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec

from w2c.errors import ConfigError, ModelError
from w2c_grounding.card import ModelCard, read_card
from w2c_grounding.family import Family
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.wording import check_template

EMBEDDED = Path(__file__).parent / "embedded"


def _load_clipseg(config: ModelConfig, source: str, card: ModelCard) -> Family[Any]:
    from w2c_grounding.clipseg import ClipSeg

    return ClipSeg.load(config, source, card.template)


FAMILIES: dict[str, Callable[[ModelConfig, str, ModelCard], Family[Any]]] = {
    "clipseg": _load_clipseg,
}


def load(config: ModelConfig) -> tuple[Family[Any], ModelCard]:
    """Load a model.

    Returns:
        The model, and its card with the configuration's own threshold and template in it.

    Raises:
        ConfigError: the family is unknown or a value makes no sense.
        ModelError: files are missing or damaged; the message says which.
    """
    if config.family not in FAMILIES:
        known = ", ".join(sorted(FAMILIES))
        raise ConfigError(f"no model family '{config.family}'; known: {known}")
    source, directory = resolve(config)
    card = read_card(directory, fallback_name=Path(source).name if directory else source)
    if config.threshold is not None:
        card = msgspec.structs.replace(card, threshold=config.threshold)
    if config.template is not None:
        card = msgspec.structs.replace(card, template=check_template(config.template))
    return FAMILIES[config.family](config, source, card), card


def resolve(config: ModelConfig) -> tuple[str, Path | None]:
    """Return what to give to `from_pretrained`, and the directory where it is one.

    Raises:
        ModelError: a path does not exist, or is no checkpoint directory.
    """
    if not config.model:
        return str(check_directory(EMBEDDED)), EMBEDDED
    path = Path(config.model).expanduser()
    if path.exists():
        return str(check_directory(path)), path
    # A hub id is 'name' or 'owner/name'; anything else can only have been meant as a path.
    if path.is_absolute() or config.model.startswith((".", "~")) or config.model.count("/") > 1:
        raise ModelError(f"no checkpoint directory at {path}; check --model")
    return config.model, None


def check_directory(directory: Path) -> Path:
    """Return the directory. Raises ModelError that names the files it lacks."""
    if not directory.is_dir():
        raise ModelError(f"{directory} is no directory; --model takes a checkpoint directory")
    missing = [
        " or ".join(alternatives)
        for alternatives in (
            ("config.json",),
            ("model.safetensors", "model.safetensors.index.json", "pytorch_model.bin"),
            ("preprocessor_config.json", "processor_config.json"),
            ("tokenizer.json", "vocab.json"),
        )
        if not any((directory / name).is_file() for name in alternatives)
    ]
    if missing:
        raise ModelError(
            f"{directory} is no complete checkpoint: it lacks {', '.join(missing)}. "
            "Copy the whole directory, or make one with: w2c train grounding"
        )
    return directory
