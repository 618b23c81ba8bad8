"""Every kind of object: how it is built, what people call it, how big and how heavy it is."""

from functools import lru_cache

import numpy as np

from w2c.errors import ConfigError
from w2c_sim_robot.scenes.objects.kind import MANY, OAK, WOODEN, Kind
from w2c_sim_robot.scenes.objects.kinds_home import HOME
from w2c_sim_robot.scenes.objects.kinds_work import WORK
from w2c_sim_robot.scenes.objects.materials import finished
from w2c_sim_robot.scenes.objects.palette import COLOURS
from w2c_sim_robot.scenes.objects.shape import Shape, Size
from w2c_sim_robot.scenes.scene import SceneObject

__all__ = ["KINDS", "MANY", "MOVABLE_KINDS", "OAK", "WOODEN", "Kind", "make_object", "shape_of"]

KINDS: dict[str, Kind] = {**HOME, **WORK}
MOVABLE_KINDS = tuple(name for name, kind in KINDS.items() if not kind.furniture)
FURNITURE_KINDS = tuple(name for name, kind in KINDS.items() if kind.furniture)


def shape_of(item: SceneObject) -> Shape:
    """Build the shape of an object; the same object always gets the same print and grain."""
    return _shape(item.kind, item.size, item.material, item.variant)


@lru_cache(maxsize=48)
def _shape(kind: str, size: Size, material: str, variant: int) -> Shape:
    row = KINDS[kind]
    shape = row.build(size, np.random.default_rng([variant, 7]))
    if material == row.material:
        return shape
    return finished(shape, material, np.random.default_rng([variant, 13]))


def random_size(kind: str, rng: np.random.Generator, scale: float = 0.12) -> Size:
    """Return extents [m] of one of its kind."""
    row = KINDS[kind]
    common = 1.0 if row.furniture else 1.0 + rng.uniform(-scale, scale)
    x, y, z = (
        extent * common * (1.0 + rng.uniform(-s, s))
        for extent, s in zip(row.size, row.stretch, strict=True)
    )
    return float(x), float(y), float(z)


def make_object(
    kind: str,
    colour: str,
    position: tuple[float, float, float],
    *,
    name: str | None = None,
    size: Size | None = None,
    yaw: float = 0.0,
    variant: int = 0,
    movable: bool | None = None,
    material: str | None = None,
) -> SceneObject:
    """Return an upright object; what is not given is usual for its kind. `yaw` about z [rad].

    Raises:
        ConfigError: its kind is never made of this material.
    """
    row = KINDS[kind]
    if material is not None and material not in row.materials:
        raise ConfigError(
            f"a {row.names[0]} of {material}; it may be of: {', '.join(row.materials)}"
        )
    extents = row.size if size is None else size
    share = float(np.prod(np.asarray(extents) / np.asarray(row.size)))
    return SceneObject(
        name=name or kind,
        kind=kind,
        names=row.names,
        colour=colour,
        material=row.material if material is None else material,
        size=extents,
        position=position,
        orientation=(0.0, 0.0, float(np.sin(yaw / 2)), float(np.cos(yaw / 2))),
        mass=max(0.01, row.mass * share),
        movable=(not row.furniture) if movable is None else movable,
        support=row.support,
        variant=variant,
    )


UNKNOWN_COLOURS = {colour for row in KINDS.values() for colour in row.colours} - set(COLOURS)
if UNKNOWN_COLOURS:
    raise ValueError(f"the catalogue names colours the palette lacks: {sorted(UNKNOWN_COLOURS)}")
