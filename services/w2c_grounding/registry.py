"""Which model to load, from where, and how its answers are to be read.

A checkpoint directory of this project carries `grounding.json` beside the weights: the phrase
template, the calibrated threshold and the vocabulary. A public checkpoint has none; then the
defaults below hold, and the configuration may set its own.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec

from w2c.errors import ConfigError, ModelError
from w2c_grounding.family import Family
from w2c_grounding.wording import check_template

Dtype = Literal["float32", "bfloat16", "float16"]

EMBEDDED = Path(__file__).parent / "embedded"
CARD_FILE = "grounding.json"

# What the authors' demo of CLIPSeg leads to expect; uncalibrated. Set --threshold for a public
# checkpoint.
DEFAULT_THRESHOLD = 0.4
DEFAULT_TEMPLATE = "{}"


class ModelConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One row of the registry: everything that decides what a model answers."""

    family: str = "clipseg"
    """One of `FAMILIES`"""
    model: str = ""
    """Checkpoint directory, or id on the Hugging Face hub; empty = the embedded model"""
    revision: str = ""
    """Commit or tag of a hub id; empty = the newest that is present"""
    allow_download: bool = False
    """True: a hub id that is not on this machine is fetched. False: only local files are read"""
    dtype: Dtype = "float32"
    device: str = "cpu"
    """cpu, cuda, cuda:1 ..."""
    threads: Annotated[int, msgspec.Meta(ge=1, le=256)] = 2
    """CPU threads of one answer"""
    threshold: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] | None = None
    """A phrase whose peak is below it is not in the picture; None = the checkpoint's own"""
    template: str | None = None
    """Text around a phrase, as in 'a photo of a {}'; None = the checkpoint's own"""


class ModelCard(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`grounding.json` of a checkpoint: how it was trained to be asked, and how to read it."""

    name: Annotated[str, msgspec.Meta(min_length=1, max_length=100)]
    template: str = DEFAULT_TEMPLATE
    threshold: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] = DEFAULT_THRESHOLD
    vocabulary: list[str] | None = None
    """Words of the training phrases that named something; None = not known"""


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


def read_card(directory: Path | None, fallback_name: str) -> ModelCard:
    """Return the card of a checkpoint directory, or the defaults where it has none.

    Raises:
        ModelError: the card is malformed.
    """
    path = None if directory is None else directory / CARD_FILE
    if path is None or not path.is_file():
        return ModelCard(name=fallback_name[-100:])
    try:
        card = msgspec.json.decode(path.read_bytes(), type=ModelCard)
        check_template(card.template)
    except (OSError, msgspec.DecodeError, UnicodeDecodeError, ConfigError) as error:
        raise ModelError(f"model card {path}: {error}") from error
    return card


def write_card(card: ModelCard, directory: Path) -> None:
    """Write the card of a checkpoint directory."""
    encoded = msgspec.json.format(msgspec.json.encode(card), indent=1)
    (directory / CARD_FILE).write_bytes(encoded + b"\n")
