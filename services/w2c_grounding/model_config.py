"""Everything that decides which model is loaded, from where, and what it answers."""

from typing import Annotated, Literal

import msgspec

from w2c_grounding.pointer.options import PointerOptions

Dtype = Literal["float32", "bfloat16", "float16"]


class ModelConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One row of the registry."""

    family: str = ""
    """One of `registry.FAMILIES`; empty = what the checkpoint says of itself"""
    model: str = ""
    """Name of `known.KNOWN`, checkpoint directory, or id on the Hugging Face hub; empty = the
    embedded model"""
    revision: str = ""
    """Commit or tag of a hub id; empty = the newest that is present"""
    allow_download: bool = False
    """True: a hub id that is not on this machine is fetched. False: only local files are read"""
    dtype: Dtype = "float32"
    device: str = "cpu"
    """cpu, cuda, cuda:1 ..."""
    input_size: Annotated[int, msgspec.Meta(ge=16, le=4096)] | None = None
    """What the picture is scaled to for the model [px]: the side of a square, or the shorter side
    where the family keeps the shape; None = as the checkpoint was trained"""
    threads: Annotated[int, msgspec.Meta(ge=1, le=256)] = 2
    """CPU threads of one answer"""
    threshold: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] | None = None
    """A phrase whose peak is below it is not in the picture; None = the checkpoint's own"""
    template: str | None = None
    """Text around a phrase, as in 'a photo of a {}'; None = the checkpoint's own"""
    pointer: PointerOptions = PointerOptions()
    """Of the families `pointer` and `pointer-local`"""
