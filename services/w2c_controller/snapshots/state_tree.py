"""All that changes in a tree of objects, as numbers, words and arrays; and back, bit by bit.

What an object remembers is found by looking at it, not by a list that someone keeps: a part that
gets a new attribute tomorrow is captured tomorrow. Left out are objects of other packages, what can
be called, and the types that the caller names as constant.

Restoring writes into the objects that are there: arrays keep their place in memory, since compiled
functions hold them. An object that is not there (a goal, a path) is made anew.
"""

import sys
from collections import deque
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from w2c.errors import ControlError

PACKAGE = "w2c_controller."
_KIND = "@"
_AGAIN = "again"
_SEQUENCES: dict[str, Callable[[list[Any]], Any]] = {
    "list": list,
    "tuple": tuple,
    "deque": deque,
    "set": set,
}
_SKIP: Any = object()
_Kind = tuple[str, bool, tuple[str, ...], tuple[str, ...]]
_PLAIN = frozenset({type(None), bool, int, float, str})


class SnapshotError(ControlError):
    """A snapshot does not fit this controller."""


def capture(
    root: object,
    constant: tuple[type, ...] = (),
    without: Mapping[type, tuple[str, ...]] = MappingProxyType({}),
    only: Mapping[type, tuple[str, ...]] = MappingProxyType({}),
) -> Any:
    """Return the state of an object of this package and of all that it holds.

    Args:
        root: Where to begin.
        constant: Types whose objects do not change, or need not be kept.
        without: Attributes of a type that need not be kept.
        only: Attributes of a type that must be kept; the others need not.
    """
    return _Encoder(constant, without, only).fields(root)


def restore(root: object, tree: Any) -> None:
    """Bring an object, and all that it holds, to a captured state.

    Raises:
        SnapshotError: the state is of other objects than these. They may be changed in part: make
            new ones.
    """
    try:
        if _name(type(root)) != tree[_KIND]:
            raise SnapshotError(f"the snapshot is of a {tree[_KIND]}, not of a {_name(type(root))}")
        _Decoder().fields(root, tree)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise SnapshotError(f"the snapshot does not fit this controller: {error}") from error


class _Encoder:
    """Goes down a tree of objects once."""

    def __init__(
        self,
        constant: tuple[type, ...],
        without: Mapping[type, tuple[str, ...]],
        only: Mapping[type, tuple[str, ...]],
    ) -> None:
        self._constant = constant
        self._without = without
        self._only = only
        self._seen: dict[int, object] = {}
        self._kinds: dict[type, _Kind] = {}
        # Functions, not methods: a method would hold this object, which only the garbage collector
        # could free then, and the loop keeps that from running.
        self._encoders: dict[type, Callable[[_Encoder, Any], Any]] = {}

    def fields(self, value: Any) -> Any:
        """Return the attributes of an object of this package, by name."""
        kind = type(value)
        name, frozen, without, only = self._kinds.get(kind) or self._describe(kind)
        if not frozen:
            if id(value) in self._seen:
                return {_KIND: _AGAIN}
            self._seen[id(value)] = value
        kept = {_KIND: name}
        held = vars(value)
        for key in only or held:
            if key not in without:
                part = self._any(held[key])
                if part is not _SKIP:
                    kept[key] = part
        return kept

    def _describe(self, kind: type) -> _Kind:
        """Return the name of a type, whether its objects are values, and what is kept of them."""
        without, only = self._without.get(kind, ()), self._only.get(kind, ())
        self._kinds[kind] = _name(kind), _is_value(kind), without, only
        return self._kinds[kind]

    def _any(self, value: Any) -> Any:
        kind = type(value)
        if kind in _PLAIN:
            return value
        if kind is np.ndarray:
            return value.copy()
        encode = self._encoders.get(kind)
        if encode is None:
            encode = self._encoders[kind] = self._encoder(kind)
        return encode(self, value)

    def _encoder(self, kind: type) -> "Callable[[_Encoder, Any], Any]":
        """Return how objects of a type are encoded."""
        if issubclass(kind, self._constant):
            return _skip
        if issubclass(kind, np.generic):
            return _item
        if issubclass(kind, dict):
            return _Encoder._dict
        if kind.__name__ in _SEQUENCES:
            return _Encoder._sequence
        return _Encoder.fields if kind.__module__.startswith(PACKAGE) else _skip

    def _dict(self, value: dict[Any, Any]) -> Any:
        items = [[self._any(key), self._any(held)] for key, held in value.items()]
        if any(held is _SKIP for _, held in items):
            return _SKIP
        return {_KIND: "dict", "items": items}

    def _sequence(self, value: Any) -> Any:
        items = [self._any(held) for held in value]
        if any(item is _SKIP for item in items):
            return _SKIP
        return {_KIND: type(value).__name__, "items": items}


class _Decoder:
    """Goes down a captured tree, and the objects that are there beside it."""

    def __init__(self) -> None:
        self._written: dict[int, bytes] = {}

    def fields(self, existing: Any, tree: Any) -> Any:
        """Return the object of a tree: the existing one where it is of that kind."""
        kind = str(tree.get(_KIND))
        if _name(type(existing)) != kind or _is_value(type(existing)):
            existing = object.__new__(_find(kind))
        for name, held in tree.items():
            if name != _KIND:
                # Values are frozen: they do not let themselves be set otherwise.
                object.__setattr__(existing, name, self._any(getattr(existing, name, None), held))
        return existing

    def _any(self, existing: Any, value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return self._array(existing, value)
        if not isinstance(value, dict):
            return value
        kind = value.get(_KIND)
        if kind == _AGAIN:
            return existing
        if kind == "dict":
            return self._dict(existing, value["items"])
        if kind in _SEQUENCES:
            return self._sequence(existing, kind, value["items"])
        return self.fields(existing, value)

    def _array(self, existing: Any, value: Any) -> Any:
        fits = isinstance(existing, np.ndarray) and existing.shape == value.shape
        if not fits or not existing.flags.writeable:
            return value.copy()
        # One array may stand in two places where two values belong: then the second gets its own.
        payload = value.tobytes()
        if self._written.setdefault(id(existing), payload) != payload:
            return value.astype(existing.dtype)
        np.copyto(existing, value, casting="unsafe")
        return existing

    def _dict(self, existing: Any, items: list[Any]) -> Any:
        held = existing if isinstance(existing, dict) else {}
        new = {}
        for coded, item in items:
            key = self._any(None, coded)
            new[key] = self._any(held.get(key), item)
        held.clear()
        held.update(new)
        return held

    def _sequence(self, existing: Any, kind: str, items: list[Any]) -> Any:
        same = type(existing).__name__ == kind and len(existing) == len(items) and kind != "set"
        held = list(existing) if same else [None] * len(items)
        new = [self._any(was, item) for was, item in zip(held, items, strict=True)]
        if same and all(now is was for now, was in zip(new, held, strict=True)):
            return existing
        if same and kind == "list":
            existing[:] = new
            return existing
        return _SEQUENCES[kind](new)


def _skip(_encoder: _Encoder, _value: Any) -> Any:
    return _SKIP


def _item(_encoder: _Encoder, value: np.generic) -> Any:
    return value.item()


def _is_value(kind: type) -> bool:
    """Return whether objects of a type are values, which stand for themselves wherever they are."""
    parameters = getattr(kind, "__dataclass_params__", None)
    return parameters is not None and bool(parameters.frozen)


def _name(kind: type) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"


def _find(name: str) -> type:
    """Return a class of this package by its full name. Raises SnapshotError."""
    module, _, word = name.rpartition(".")
    found = getattr(sys.modules.get(module), word, None) if name.startswith(PACKAGE) else None
    if not isinstance(found, type):
        raise SnapshotError(f"the snapshot holds a '{name}', which this version does not know")
    return found
