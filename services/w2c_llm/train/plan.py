"""What a training run depends on, and what it gives. Imports nothing heavy."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from w2c.errors import ConfigError

WeightsName = Literal["f32", "f16", "q8_0"]
LAYERS = 6
"""Of a new network"""
SCRATCH_RATE, CONTINUED_RATE = 5e-3, 1e-3
"""Peak learning rates: a trained network forgets at the first of them"""


@dataclass(frozen=True)
class Shape:
    """Numbers of the network that a user may choose; None = the default, or those of `--from`."""

    layers: int | None = None
    width: int | None = None
    feed_forward: int | None = None
    vocabulary: int | None = None
    begin_layers: int | None = None
    """Of a network that grows to `layers` on the way; None = all of them from the beginning"""

    @property
    def new_layers(self) -> int:
        """Layers of a new network, at the end of its run."""
        return self.layers or LAYERS


@dataclass(frozen=True)
class TrainingPlan:
    """Everything a run depends on."""

    corpus: Path
    heldout: Path
    output: Path
    minutes: float = 60.0
    steps: int | None = None
    begin_with: tuple[Path, ...] = ()
    """GGUF files or checkpoints, whose mean it begins with; none = random weights"""
    dialogues: Path | None = None
    dialogues_share: float = 0.2
    """Of the examples of every epoch"""
    shape: Shape = Shape()
    batch: int = 96
    peak_rate: float | None = None
    prompt_weight: float = 0.0
    dropout: float = 0.0
    compiled: bool = False
    threads: int = 2
    weights: WeightsName = "q8_0"
    seed: int = 0
    resume: bool = False

    @property
    def rate(self) -> float:
        """The peak learning rate."""
        default = CONTINUED_RATE if self.begin_with else SCRATCH_RATE
        return default if self.peak_rate is None else self.peak_rate

    @property
    def budget(self) -> str:
        """The flag that ends the run."""
        return f"--minutes {self.minutes:g}" if self.steps is None else f"--steps {self.steps}"

    def check(self) -> None:
        """Raise ConfigError for what cannot be trained."""
        limits = (
            ("--minutes", self.minutes, 0.0, 1e5),
            ("--steps", 1 if self.steps is None else self.steps, 1, 1e8),
            ("--batch", self.batch, 1, 4096),
            ("--rate", self.rate, 1e-7, 1.0),
            ("--prompt-weight", self.prompt_weight, 0.0, 1.0),
            ("--dropout", self.dropout, 0.0, 0.9),
            ("--threads", self.threads, 1, 256),
            ("--seed", self.seed, 0, 2**31 - 1),
            ("--with-share", self.dialogues_share, 0.001, 0.9),
            ("--layers", self.shape.layers or 1, 1, 64),
            ("--width", self.shape.width or 64, 64, 4096),
            ("--feed-forward", self.shape.feed_forward or 32, 32, 16384),
            # 256 bytes and the special tokens are always there; a token is two bytes on disk.
            ("--vocabulary", self.shape.vocabulary or 300, 262, 65535),
        )
        for name, value, low, high in limits:
            if not low <= value <= high:
                raise ConfigError(f"{name} is {value:g}; it must be {low:g} to {high:g}")
        for name, size in (
            ("--width", self.shape.width),
            ("--feed-forward", self.shape.feed_forward),
        ):
            unit = 64 if name == "--width" else 32
            if size is not None and size % unit:
                raise ConfigError(f"{name} is {size}; it must be a multiple of {unit}")
        self._check_growth()

    def _check_growth(self) -> None:
        begin, layers = self.shape.begin_layers, self.shape.new_layers
        if begin is None:
            return
        if self.begin_with:
            raise ConfigError(
                "--begin-layers is for random weights; with --from leave it out, and give --layers "
                "for a deeper network"
            )
        if not 1 <= begin < layers:
            raise ConfigError(
                f"--begin-layers is {begin}; it must be 1 to {layers - 1}, less than --layers"
            )


@dataclass(frozen=True)
class TrainingResult:
    """What a run gave."""

    model_path: Path
    card_path: Path
    megabytes: float
    parameters: int
    examples_seen: int
    steps: int
    minutes: float
    exact_match: dict[str, tuple[int, int]]
    """Task -> (exact matches, examples) on the held-out file"""
    largest_logit_difference: float
    """Between transformers and llama.cpp, on held-out prompts, in standard deviations"""
    seed: int
