"""Which model to load, and from where; the configuration may set its own threshold and template."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from w2c.errors import ConfigError, ModelError
from w2c_grounding.card import ModelCard, read_card
from w2c_grounding.family import Family
from w2c_grounding.guard import Guarded
from w2c_grounding.known import KNOWN
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.sizes import OTHERS, SIZE_WORDS, ComparesSizes
from w2c_grounding.wording import check_template

if TYPE_CHECKING:
    from w2c_grounding.things.proposals import Thing

EMBEDDED = Path(__file__).parent / "embedded"
EMBEDDED_NAME = "embedded"
"""What lists and `w2c ground use` call the model of this repository"""

Loader = Callable[[ModelConfig, str, ModelCard], Family[Any]]
"""(configuration, what to give to `from_pretrained`, card) -> model. Imports its module when it is
called: torch and a model class of transformers take seconds. Raises ConfigError or ModelError."""


@dataclass(frozen=True)
class FamilyEntry:
    """A kind of model that can be loaded."""

    load: Loader
    model_types: tuple[str, ...]
    """What `config.json` of its checkpoints calls their architecture; () = anything"""
    threshold: float = 0.4
    """For a checkpoint without a card; a convention of the family's authors, not calibrated"""
    scales: bool = True
    """Takes `input_size`; False: its models read pictures of one size alone"""
    local_files: bool = True
    """False: `model` is no checkpoint (a name on a server); nothing is looked for on disk"""


def _load_clipseg(config: ModelConfig, source: str, card: ModelCard) -> Family[Any]:
    from w2c_grounding.clipseg import ClipSeg

    return ClipSeg.load(config, source, card.template)


def _load_clip_surgery(config: ModelConfig, source: str, card: ModelCard) -> Family[Any]:
    from w2c_grounding.clip_surgery import ClipSurgery

    return ClipSurgery.load(config, source, card.template)


def _load_grounding_dino(config: ModelConfig, source: str, card: ModelCard) -> Family[Any]:
    from w2c_grounding.grounding_dino import GroundingDino

    return GroundingDino.load(config, source, card.template)


def _load_owlv2(config: ModelConfig, source: str, card: ModelCard) -> Family[Any]:
    from w2c_grounding.owlv2 import Owlv2

    return Owlv2.load(config, source, card.template)


def _load_florence(config: ModelConfig, source: str, card: ModelCard) -> Family[Any]:
    from w2c_grounding.florence import Florence

    return Florence.load(config, source, card.template, "boxes")


def _load_florence_outline(config: ModelConfig, source: str, card: ModelCard) -> Family[Any]:
    from w2c_grounding.florence import Florence

    return Florence.load(config, source, card.template, "outlines")


def _load_sam3(config: ModelConfig, source: str, card: ModelCard) -> Family[Any]:
    from w2c_grounding.sam3 import Sam3

    return Sam3.load(config, source, card.template)


def _load_pointer(config: ModelConfig, source: str, card: ModelCard) -> Family[Any]:
    from w2c_grounding.pointer.loading import load_server

    return load_server(config, source, card.template)


def _load_local_pointer(config: ModelConfig, source: str, card: ModelCard) -> Family[Any]:
    from w2c_grounding.pointer.loading import load_local

    return load_local(config, source, card.template)


FAMILIES: dict[str, FamilyEntry] = {
    "clipseg": FamilyEntry(_load_clipseg, ("clipseg",)),
    "clip-surgery": FamilyEntry(_load_clip_surgery, ("clip",), threshold=0.5),
    "grounding-dino": FamilyEntry(
        _load_grounding_dino, ("grounding-dino", "mm-grounding-dino"), threshold=0.25
    ),
    "owlv2": FamilyEntry(_load_owlv2, ("owlv2",), threshold=0.1),
    "florence": FamilyEntry(_load_florence, ("florence2",), threshold=0.3, scales=False),
    "florence-outline": FamilyEntry(
        _load_florence_outline, ("florence2",), threshold=0.3, scales=False
    ),
    "sam3": FamilyEntry(_load_sam3, ("sam3", "sam3_video"), threshold=0.5, scales=False),
    "pointer": FamilyEntry(_load_pointer, (), threshold=0.5, scales=False, local_files=False),
    "pointer-local": FamilyEntry(
        _load_local_pointer,
        ("qwen2_vl", "qwen2_5_vl", "qwen3_vl", "qwen3_5", "molmo2", "llava", "internvl", "glm4v"),
        threshold=0.5,
        scales=False,
    ),
}


def load(
    config: ModelConfig, changed: Callable[[ModelCard], ModelCard] = lambda card: card
) -> tuple[Family[Any], ModelCard]:
    """Load a model.

    Args:
        config: Which one, and how.
        changed: Returns the card that counts instead of the checkpoint's own: a training asks a
            model without what it adds.

    Returns:
        The model, guarded against lack of memory, and its card with the configuration's own
        threshold and template in it.

    Raises:
        ConfigError: the family is unknown or a value makes no sense.
        ModelError: files are missing, damaged or of another family; the message says which.
    """
    if config.family and config.family not in FAMILIES:
        known = ", ".join(sorted(FAMILIES))
        raise ConfigError(f"no model family '{config.family}'; known: {known}")
    name = config.model
    if name in KNOWN:
        config = KNOWN[name].applied_to(config)
    if config.family and not FAMILIES[config.family].local_files:
        source, directory = config.model, None
    else:
        source, directory = resolve(config)
        config = msgspec.structs.replace(config, family=family_of(config, source, directory))
    entry = FAMILIES[config.family]
    if config.input_size is not None and not entry.scales:
        raise ConfigError(
            f"--input-size {config.input_size}: family {config.family} has no size to choose; "
            "leave it out (what pointers are shown is bounded by --pointer.longest-side)"
        )
    card = changed(_card(config, entry, directory, name or source))
    family = entry.load(config, source, card)
    if card.second_look and directory is not None:
        family = _looking_again(family, directory, config.device, card)
    if card.outlines and directory is not None:
        family = _drawing_outlines(family, directory, config.device, card)
    if card.compares_sizes:
        family = ComparesSizes(family, card.threshold, card.edge, card.names_of_size)
        card = _knowing_sizes(card)
    return Guarded(family, config.device), card


def _looking_again(
    family: Family[Any], directory: Path, device: str, card: ModelCard
) -> Family[Any]:
    """Return the family with its second look. Raises ModelError."""
    from w2c_grounding.folding import folded
    from w2c_grounding.second_look import weights
    from w2c_grounding.second_look.looks_again import LooksAgain

    network = folded(weights.read(directory))
    return LooksAgain(family, network, device, card.edge, _thing_finder(directory, device, card))


def _thing_finder(
    directory: Path, device: str, card: ModelCard
) -> "Callable[[Any], Sequence[Thing]] | None":
    """Return what finds things before anything is asked. Raises ModelError."""
    if not card.things:
        return None
    from w2c_grounding.folding import folded
    from w2c_grounding.things import weights
    from w2c_grounding.things.finder import ThingFinder

    return ThingFinder(folded(weights.read(directory)), device)


def _drawing_outlines(
    family: Family[Any], directory: Path, device: str, card: ModelCard
) -> Family[Any]:
    """Return the family with its outlines. Raises ModelError."""
    from w2c_grounding.outline import weights
    from w2c_grounding.outline.draws_outlines import DrawsOutlines

    # Things that are compared by size may be a little fainter than what is found.
    least = OTHERS * card.threshold
    return DrawsOutlines(family, weights.read(directory), least, device, card.edge)


def _knowing_sizes(card: ModelCard) -> ModelCard:
    """Return the card with the words of size among those that are understood."""
    if card.vocabulary is None:
        return card
    return msgspec.structs.replace(card, vocabulary=sorted({*card.vocabulary, *SIZE_WORDS}))


def _card(config: ModelConfig, entry: FamilyEntry, directory: Path | None, name: str) -> ModelCard:
    """Return the checkpoint's card, what it leaves open filled in. Raises ModelError."""
    card = read_card(directory, Path(name).name if directory else name, entry.threshold)
    if config.threshold is not None:
        card = msgspec.structs.replace(card, threshold=config.threshold)
    if config.template is not None:
        card = msgspec.structs.replace(card, template=check_template(config.template))
    return card


def resolve(config: ModelConfig) -> tuple[str, Path | None]:
    """Return what to give to `from_pretrained`, and the directory where it is one.

    Raises:
        ModelError: a path does not exist, or is no checkpoint directory.
    """
    if config.model in ("", EMBEDDED_NAME):
        return str(check_directory(EMBEDDED)), EMBEDDED
    path = Path(config.model).expanduser()
    if path.exists():
        return str(check_directory(path)), path
    # A hub id is 'name' or 'owner/name'; anything else can only have been meant as a path.
    if path.is_absolute() or config.model.startswith((".", "~")) or config.model.count("/") > 1:
        raise ModelError(f"no checkpoint directory at {path}; check --model")
    return config.model, None


def family_of(config: ModelConfig, source: str, directory: Path | None) -> str:
    """Return the family that reads a checkpoint.

    Raises:
        ConfigError: none does.
        ModelError: the one that the configuration names does not, or config.json is malformed.
    """
    found = _model_type(config, source, directory)
    readers = [name for name, entry in FAMILIES.items() if found in entry.model_types]
    if config.family:
        wanted = FAMILIES[config.family].model_types
        if found in wanted or not wanted:
            return config.family
        fitting = f"use --family {readers[0]}" if readers else "no family here reads it"
        raise ModelError(
            f"'{source}' is a checkpoint of architecture '{found}', and family {config.family} "
            f"reads {', '.join(wanted)}: {fitting}, or name another --model"
        )
    if not readers:
        raise ModelError(
            f"'{source}' is a checkpoint of architecture '{found}', which no family here reads; "
            f"known: {', '.join(sorted(FAMILIES))}"
        )
    return readers[0]


def _model_type(config: ModelConfig, source: str, directory: Path | None) -> str:
    if directory is None:
        from w2c_grounding.pretrained import model_type

        return model_type(config, source)
    path = directory / "config.json"
    try:
        values = json.loads(path.read_bytes())
    except (OSError, ValueError) as error:
        raise ModelError(f"{path} cannot be read: {error}; copy the checkpoint again") from error
    return str(values.get("model_type", "")) if isinstance(values, dict) else ""


def check_directory(directory: Path) -> Path:
    """Return the directory. Raises ModelError that names the files it lacks."""
    if not directory.is_dir():
        raise ModelError(f"{directory} is no directory; --model takes a checkpoint directory")
    missing = [
        " or ".join(alternatives)
        for alternatives in (
            ("config.json",),
            (
                "model.safetensors",
                "model.safetensors.index.json",
                "pytorch_model.bin",
                "pytorch_model.bin.index.json",
            ),
            ("preprocessor_config.json", "processor_config.json"),
            ("tokenizer.json", "vocab.json", "vocab.txt"),
        )
        if not any((directory / name).is_file() for name in alternatives)
    ]
    if missing:
        raise ModelError(
            f"{directory} is no complete checkpoint: it lacks {', '.join(missing)}. "
            "Copy the whole directory, or make one with: w2c train grounding"
        )
    return directory
