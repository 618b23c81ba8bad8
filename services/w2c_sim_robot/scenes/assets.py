"""Things without colour and place: what a set of scenes is made of."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from w2c_sim_robot.scenes.held_out import HELD_OUT_KINDS, kinds_for, materials_for
from w2c_sim_robot.scenes.objects.catalogue import KINDS, MOVABLE_KINDS, random_size
from w2c_sim_robot.scenes.objects.shape import Size

PaperScene = Literal["a", "b", "c", "d"]
PAPER_KINDS: dict[PaperScene, tuple[str, ...]] = {
    "a": ("book", "mug", "bottle", "bowl"),
    "b": ("dishwasher", "plate", "dish_rack", "mug"),
    "c": ("mallet", "nail_box", "toolbox", "screwdriver"),
    "d": ("fridge", "cheez_it_box", "drape", "bowl"),
}
"""What is in the scenes of the paper beside table and counter. That of (a) is always in stock"""
CARRIERS = ("table", "counter", "shelf")
SCENES_PER_STOCK = 50
"""Scenes of consecutive seeds that have things in common"""
STOCK_KINDS = 24
"""Of one model: more make it slow to compile and to draw"""
FLOOR_KINDS_IN_STOCK = 5
JUDGING_SHARE = 0.3
"""Of the kinds in a stock for judging: those that are never trained on"""
OTHER_SIZE = (0.66, 0.74)
"""Of a second one of a kind that is told apart by its size"""


@dataclass(frozen=True)
class Asset:
    """A thing without its colour and place."""

    name: str
    kind: str
    size: Size
    variant: int
    material: str
    for_paper: bool = False
    """In stock only so that scenes like one of the paper's have it"""


def paper_scene_of(seed: int) -> PaperScene:
    """Return which of the paper's scenes the things of a seed may make: in blocks, in turn."""
    letters: tuple[PaperScene, ...] = get_args(PaperScene)
    return letters[seed // SCENES_PER_STOCK % len(letters)]


def has_things_of(paper_scene: PaperScene, assets: tuple[Asset, ...]) -> bool:
    """Whether a scene like this one of the paper can be made of these assets."""
    return {asset.kind for asset in assets}.issuperset(PAPER_KINDS[paper_scene])


def random_assets(
    rng: np.random.Generator,
    copies: int = 2,
    *,
    judging: bool = False,
    paper_scene: PaperScene = "a",
) -> tuple[Asset, ...]:
    """Return `copies` things of each kind in stock, and one of each kind of furniture.

    The kinds of `paper_scene` are among them.
    """
    stock = _stock(rng, judging)
    missing = tuple(kind for kind in PAPER_KINDS[paper_scene] if kind not in stock)
    # Of a generator of their own, so that the others are the same whatever the paper's scene.
    own = rng.spawn(1)[0]
    return (
        *_of_kinds((*CARRIERS, *stock), rng, copies, judging),
        *(replace(asset, for_paper=True) for asset in _of_kinds(missing, own, copies, judging)),
    )


def _of_kinds(
    kinds: tuple[str, ...], rng: np.random.Generator, copies: int, judging: bool
) -> Iterator[Asset]:
    """Yield `copies` things of each kind, of furniture one; two differ in some way."""
    for kind in kinds:
        furniture = KINDS[kind].furniture
        first: Asset | None = None
        for number in range(1 if furniture else copies):
            variant = int(rng.integers(1_000_000))
            size = random_size(kind, rng)
            material = _material(rng, kind, judging)
            if first is not None:
                way = rng.random()
                if way < 0.4:
                    scale = float(rng.uniform(*OTHER_SIZE))
                    size = (first.size[0] * scale, first.size[1] * scale, first.size[2] * scale)
                    material = first.material
                elif way < 0.6:
                    material = _another(rng, kind, first.material, judging)
            asset = Asset(f"{kind}_{number}", kind, size, variant, material)
            first = first or asset
            yield asset


def _stock(rng: np.random.Generator, judging: bool) -> tuple[str, ...]:
    """Return the kinds of a stock: the paper's, some for the floor, some for judging, others."""
    allowed = [kind for kind in kinds_for(judging) if kind in MOVABLE_KINDS]
    order = [allowed[i] for i in rng.permutation(len(allowed))]
    chosen = list(PAPER_KINDS["a"])
    if judging:
        chosen += [k for k in order if k in HELD_OUT_KINDS][: round(JUDGING_SHARE * STOCK_KINDS)]
    chosen += [k for k in order if KINDS[k].floor and k not in chosen][:FLOOR_KINDS_IN_STOCK]
    return tuple((chosen + [k for k in order if k not in chosen])[:STOCK_KINDS])


def _material(rng: np.random.Generator, kind: str, judging: bool) -> str:
    """Return the usual material most of the time."""
    materials = materials_for(kind, judging)
    if len(materials) == 1 or rng.random() < 0.65:
        return materials[0]
    return str(rng.choice(materials[1:]))


def _another(rng: np.random.Generator, kind: str, material: str, judging: bool) -> str:
    others = [name for name in materials_for(kind, judging) if name != material]
    return str(rng.choice(others)) if others else material
