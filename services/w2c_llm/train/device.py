"""Where to train, and in which precision."""

from dataclasses import dataclass
from pathlib import Path

import torch

_CPU_FLAGS = Path("/proc/cpuinfo")
_BF16_FLAGS = {"avx512_bf16", "amx_bf16", "bf16"}
"""Of processors that multiply bfloat16; elsewhere it takes nearly three times as long as float32"""


@dataclass(frozen=True)
class Device:
    """A processor and the precision of its products."""

    torch_device: torch.device
    bf16: bool
    """Whether products are in bfloat16; sums, weights and what the optimizer keeps are float32"""
    name: str

    def autocast(self) -> torch.autocast:
        """Return the context in which to call the network."""
        return torch.autocast(self.torch_device.type, torch.bfloat16, enabled=self.bf16)


CPU = Device(torch.device("cpu"), bf16=False, name="CPU")


def best_device() -> Device:
    """Return the GPU if there is one, else the processor."""
    if torch.cuda.is_available():
        name = torch.cuda.get_device_name()
        return Device(torch.device("cuda"), torch.cuda.is_bf16_supported(), name)
    flags, name = _processor()
    return Device(torch.device("cpu"), bool(flags & _BF16_FLAGS), name)


def _processor() -> tuple[set[str], str]:
    """Return the flags and the name of the processor; none and `CPU` where Linux does not say."""
    try:
        lines = _CPU_FLAGS.read_text().splitlines()
    except OSError:
        return set(), CPU.name
    facts: dict[str, str] = {}
    for line in lines:
        key, _, value = line.partition(":")
        facts.setdefault(key.strip().lower(), value.strip())
    flags = facts.get("flags", facts.get("features", ""))
    return set(flags.split()), facts.get("model name", CPU.name)
