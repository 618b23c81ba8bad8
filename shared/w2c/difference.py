"""In what two messages differ: numbers by how much, all else at all. Pure."""

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

INFINITE = math.inf


@dataclass(frozen=True)
class Difference:
    """One place where two values are not the same."""

    path: str
    """Where, as position[3] or state.body.q[2]; of an array the place of the largest difference"""
    first: Any
    second: Any
    size: float
    """Of two numbers, in their unit; infinite where they are not two finite numbers"""

    def __str__(self) -> str:
        """Return it for people."""
        by = "" if self.size == INFINITE else f", {self.size:.3g} apart"
        return f"{self.path}: {_short(self.first)} and {_short(self.second)}{by}"


def differences(
    first: Any, second: Any, without: Collection[str] = (), path: str = ""
) -> Iterator[Difference]:
    """Yield where two values differ; nothing where they are equal bit by bit.

    NaN equals NaN, and 0 equals -0. Structs, mappings and sequences are gone into.

    Args:
        first: A message, or a part of one.
        second: Of the same kind, where they are equal.
        without: Paths that are not looked at.
        path: Of the two values.
    """
    if path in without or first is second:
        return
    if isinstance(first, np.ndarray) and isinstance(second, np.ndarray):
        yield from _arrays(first, second, path)
    elif isinstance(first, msgspec.Struct) and type(first) is type(second):
        for name in first.__struct_fields__:
            inner = f"{path}.{name}" if path else name
            yield from differences(getattr(first, name), getattr(second, name), without, inner)
    elif isinstance(first, dict) and isinstance(second, dict):
        yield from _mappings(first, second, without, path)
    elif isinstance(first, list | tuple) and isinstance(second, list | tuple):
        yield from _sequences(first, second, without, path)
    elif _is_number(first) and _is_number(second):
        yield from _numbers(first, second, path)
    elif type(first) is not type(second) or first != second:
        yield Difference(path, first, second, INFINITE)


def _arrays(first: Any, second: Any, path: str) -> Iterator[Difference]:
    if first.shape != second.shape:
        yield Difference(f"{path} (shape)", first.shape, second.shape, INFINITE)
        return
    if first.tobytes() == second.tobytes() and first.dtype == second.dtype:
        return
    if first.dtype.kind not in "fiub" or second.dtype.kind not in "fiub":
        yield Difference(path, str(first.dtype), str(second.dtype), INFINITE)
        return
    # Numbers that cannot be told apart as such, as infinity and infinity, have no difference.
    wide_first, wide_second = first.astype(np.float64), second.astype(np.float64)
    with np.errstate(invalid="ignore"):
        sizes = np.abs(wide_first - wide_second)
    sizes[np.isnan(sizes)] = INFINITE
    same = (wide_first == wide_second) | (np.isnan(wide_first) & np.isnan(wide_second))
    sizes[same] = 0.0
    if sizes.max() > 0.0:
        at = np.unravel_index(int(np.argmax(sizes)), sizes.shape)
        place = ", ".join(str(int(index)) for index in at)
        yield Difference(f"{path}[{place}]", first[at].item(), second[at].item(), float(sizes[at]))


def _mappings(
    first: dict[Any, Any], second: dict[Any, Any], without: Collection[str], path: str
) -> Iterator[Difference]:
    for key in [*first, *(key for key in second if key not in first)]:
        inner = f"{path}.{key}" if path else str(key)
        if inner in without:
            continue
        if key in first and key in second:
            yield from differences(first[key], second[key], without, inner)
        else:
            here = first.get(key, "missing"), second.get(key, "missing")
            yield Difference(inner, *here, INFINITE)


def _sequences(
    first: list[Any] | tuple[Any, ...],
    second: list[Any] | tuple[Any, ...],
    without: Collection[str],
    path: str,
) -> Iterator[Difference]:
    if len(first) != len(second):
        yield Difference(f"{path} (length)", len(first), len(second), INFINITE)
        return
    for index, (one, other) in enumerate(zip(first, second, strict=True)):
        yield from differences(one, other, without, f"{path}[{index}]")


def _numbers(first: float, second: float, path: str) -> Iterator[Difference]:
    if first == second or (math.isnan(first) and math.isnan(second)):
        return
    size = abs(first - second)
    yield Difference(path, first, second, INFINITE if math.isnan(size) else size)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _short(value: object) -> str:
    """Return a value for people: long ones cut."""
    text = repr(value)
    return text if len(text) <= 100 else f"{text[:97]}..."
