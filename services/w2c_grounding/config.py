"""Flags of the grounding process."""

from pathlib import Path
from typing import Annotated, Literal

import msgspec

from w2c.config import ServiceConfig
from w2c_grounding.model_config import Dtype, ModelConfig
from w2c_grounding.pointer.options import PointerOptions

EMBEDDED = Path(__file__).parent / "embedded"


class Config(ServiceConfig, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Configuration of the grounding process. The defaults load the embedded model."""

    family: str = ""
    """Kind of model; empty = what the checkpoint says of itself. `w2c ground models` lists them."""
    model: str = ""
    """A name of `w2c ground models`, a checkpoint directory, or an id on the Hugging Face hub;
    empty or 'embedded' = the embedded model."""
    revision: str = ""
    """Commit or tag of a hub id; empty = the newest that is present."""
    allow_download: bool = False
    """Fetch a hub id that is not on this machine."""
    dtype: Dtype = "float32"
    """Of the weights in memory."""
    device: str = "cpu"
    """cpu, cuda, cuda:1 ..."""
    input_size: Annotated[int, msgspec.Meta(ge=16, le=4096)] | None = None
    """What the picture is scaled to for the model [px]; None = as the checkpoint was trained."""
    threads: Annotated[int, msgspec.Meta(ge=1, le=256)] = 2
    """CPU threads of one answer."""
    threshold: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] | None = None
    """A phrase whose peak is below it is not in the picture; None = the checkpoint's own."""
    template: str | None = None
    """Text around a phrase, as in 'a photo of a {}'; None = the checkpoint's own."""
    pointer: PointerOptions = PointerOptions()
    """Of the families pointer and pointer-local."""
    point_rule: Literal["interior", "peak"] = "interior"
    """interior: hot and far from edges. peak: the arg-max of the paper."""
    queue_limit: Annotated[int, msgspec.Meta(ge=0, le=100)] = 8
    """Requests that may wait while one is answered; more are refused at once."""

    def model_config(self) -> ModelConfig:
        """Return the part that chooses the model."""
        return ModelConfig(**{name: getattr(self, name) for name in ModelConfig.__struct_fields__})

    def model_files(self) -> Path | None:
        """Return the model's directory; None where it is not one of this machine by its path."""
        embedded = self.model in ("", "embedded")
        path = EMBEDDED if embedded else Path(self.model).expanduser()
        return path if path.is_dir() else None
