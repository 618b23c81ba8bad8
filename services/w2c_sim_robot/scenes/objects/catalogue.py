"""Every kind of object: how it is built, what people call it, how big and how heavy it is."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from w2c_sim_robot.scenes.objects import furniture, paper, soft, tableware, tools
from w2c_sim_robot.scenes.objects.palette import COLOURS, Colour
from w2c_sim_robot.scenes.objects.shape import Builder, Shape, Size
from w2c_sim_robot.scenes.scene import SceneObject, Support

MANY = (
    "red",
    "orange",
    "yellow",
    "green",
    "blue",
    "purple",
    "pink",
    "black",
    "grey",
    "white",
    "turquoise",
)
WOODEN = ("brown", "white", "grey", "black")
OAK = (0.68, 0.49, 0.31)


@dataclass(frozen=True)
class Kind:
    """One row of the catalogue."""

    build: Builder
    names: tuple[str, ...]
    """What people call it, the usual word first"""
    material: str
    size: Size
    """Usual extents [m]"""
    stretch: tuple[float, float, float]
    """How far each extent may differ from the usual, as a share, beside the common scale"""
    colours: tuple[str, ...]
    mass: float
    """Of the usual size [kg]"""
    support: Support
    furniture: bool = False
    """Things stand on it; it stands on the floor"""
    tones: Mapping[str, Colour] = field(default_factory=dict)
    """Where this kind has another shade by the same name: a brown table is lighter than brown
    leather"""


KINDS: dict[str, Kind] = {
    "table": Kind(
        furniture.table, ("table", "desk"), "wood", (1.0, 1.7, 0.80), (0.2, 0.25, 0.06),
        WOODEN, 40.0, "carries", True, {"brown": OAK},
    ),
    "counter": Kind(
        furniture.counter, ("counter", "worktop"), "stone", (0.8, 2.0, 0.84), (0.15, 0.25, 0.06),
        ("grey", "white", "black", "brown"), 90.0, "carries", True, {"brown": OAK},
    ),
    "book": Kind(
        paper.book, ("book", "hardcover"), "paper", (0.26, 0.19, 0.035), (0.1, 0.1, 0.5),
        (*MANY, "brown"), 1.2, "carries",
    ),
    "notebook": Kind(
        paper.notebook, ("notebook", "notepad"), "paper", (0.21, 0.15, 0.014), (0.1, 0.1, 0.3),
        MANY, 0.3, "carries",
    ),
    "paper": Kind(
        paper.paper, ("paper", "sheet of paper", "page"), "paper",
        (0.297, 0.21, 0.001), (0.02, 0.02, 0.0),
        ("white", "yellow", "pink", "turquoise"), 0.01, "carries",
    ),
    "cereal_box": Kind(
        paper.cereal_box, ("cereal box", "packet"), "cardboard",
        (0.06, 0.19, 0.28), (0.15, 0.1, 0.1), MANY, 0.4, "slides",
    ),
    "box": Kind(
        paper.carton, ("box", "carton"), "cardboard", (0.22, 0.26, 0.16), (0.25, 0.25, 0.35),
        ("brown", "white", "blue", "red", "green", "grey"), 1.5, "slides",
    ),
    "mug": Kind(
        tableware.mug, ("cup", "mug"), "ceramic", (0.125, 0.088, 0.10), (0.05, 0.05, 0.12),
        MANY, 0.35, "fragile",
    ),
    "bowl": Kind(
        tableware.bowl, ("bowl", "dish"), "ceramic", (0.17, 0.17, 0.075), (0.02, 0.02, 0.2),
        MANY, 0.4, "fragile",
    ),
    "plate": Kind(
        tableware.plate, ("plate", "dish"), "ceramic", (0.25, 0.25, 0.026), (0.02, 0.02, 0.1),
        MANY, 0.5, "fragile",
    ),
    "bottle": Kind(
        tableware.bottle, ("bottle", "flask"), "glass", (0.08, 0.08, 0.27), (0.05, 0.05, 0.12),
        ("green", "blue", "brown", "red", "black", "white", "turquoise", "purple"), 0.7, "slides",
    ),
    "can": Kind(
        tableware.can, ("can", "tin"), "metal", (0.068, 0.068, 0.125), (0.05, 0.05, 0.15),
        MANY, 0.36, "slides",
    ),
    "jug": Kind(
        tableware.jug, ("jug", "pitcher"), "ceramic", (0.17, 0.13, 0.2), (0.05, 0.05, 0.12),
        MANY, 0.9, "fragile",
    ),
    "ball": Kind(
        soft.ball, ("ball",), "rubber", (0.13, 0.13, 0.13), (0.0, 0.0, 0.0),
        MANY, 0.3, "slides",
    ),
    "cloth": Kind(
        soft.cloth, ("cloth", "towel", "rag"), "cotton", (0.34, 0.28, 0.02), (0.15, 0.15, 0.3),
        (*MANY, "brown"), 0.1, "carries",
    ),
    "sponge": Kind(
        soft.sponge, ("sponge",), "", (0.13, 0.085, 0.04), (0.1, 0.1, 0.15),
        ("yellow", "orange", "pink", "blue", "purple", "turquoise"), 0.05, "slides",
    ),
    "apple": Kind(
        soft.apple, ("apple", "fruit"), "", (0.085, 0.085, 0.08), (0.03, 0.03, 0.08),
        ("red", "green", "yellow"), 0.2, "slides",
    ),
    "toolbox": Kind(
        tools.toolbox, ("toolbox", "tool box"), "metal", (0.2, 0.4, 0.21), (0.1, 0.12, 0.12),
        ("red", "blue", "grey", "black", "yellow", "orange", "green"), 6.0, "carries",
    ),
    "mallet": Kind(
        tools.mallet, ("mallet", "hammer"), "rubber", (0.32, 0.12, 0.07), (0.1, 0.1, 0.1),
        ("black", "white", "red", "orange", "blue", "green", "grey"), 0.8, "slides",
    ),
    "tray": Kind(
        tools.tray, ("tray",), "plastic", (0.28, 0.4, 0.035), (0.1, 0.1, 0.15),
        (*MANY, "brown"), 0.7, "carries",
    ),
    "crate": Kind(
        tools.crate, ("crate", "basket"), "wood", (0.24, 0.34, 0.16), (0.12, 0.12, 0.15),
        ("brown", "white", "green", "blue", "grey", "red"), 1.3, "slides",
    ),
    "block": Kind(
        tools.block, ("block", "brick"), "wood", (0.08, 0.12, 0.07), (0.25, 0.25, 0.25),
        (*MANY, "brown"), 0.5, "slides",
    ),
}  # fmt: skip

MOVABLE_KINDS = tuple(name for name, kind in KINDS.items() if not kind.furniture)
FURNITURE_KINDS = tuple(name for name, kind in KINDS.items() if kind.furniture)


def shape_of(item: SceneObject) -> Shape:
    """Build the shape of an object; the same object always gets the same print and grain."""
    return KINDS[item.kind].build(item.size, np.random.default_rng([item.variant, 7]))


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
) -> SceneObject:
    """Return an upright object; what is not given is usual for its kind. `yaw` about z [rad]."""
    row = KINDS[kind]
    extents = row.size if size is None else size
    share = float(np.prod(np.asarray(extents) / np.asarray(row.size)))
    return SceneObject(
        name=name or kind,
        kind=kind,
        names=row.names,
        colour=colour,
        material=row.material,
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
