"""Scenes by chance: furniture or floor, things on it, colours, light. Same seed, same scene."""

from itertools import combinations

import numpy as np

from w2c_sim_robot.scenes.assets import (
    PAPER_KINDS,
    Asset,
    PaperScene,
    has_things_of,
    paper_scene_of,
    random_assets,
)
from w2c_sim_robot.scenes.held_out import held_out, is_judging
from w2c_sim_robot.scenes.objects.catalogue import KINDS
from w2c_sim_robot.scenes.objects.looks import tells_apart
from w2c_sim_robot.scenes.objects.palette import COLOURS, shade
from w2c_sim_robot.scenes.placing import Arranger, Placed
from w2c_sim_robot.scenes.scene import Light, Scene, Surroundings
from w2c_sim_robot.scenes.stages import draw_stage
from w2c_sim_robot.scenes.wording import of_other_size

PAPER_SHARE = 0.2
"""Of scenes that are arranged like one of the paper's, with its things"""
PAPER_COLOURS: dict[str, str] = {
    "book": "red", "mug": "blue", "bottle": "green", "bowl": "yellow", "plate": "red",
    "mallet": "black", "nail_box": "brown", "cheez_it_box": "red",
}  # fmt: skip
"""Of the things in them"""
PAPER_ONLY_SHARE = 0.5
"""Of such scenes: nothing but the paper's things, in the paper's colours"""
CLUTTERED_SHARE = 0.25
PAIR_SHARE = 0.45
"""Of scenes with two of a kind on purpose"""
ALIKE = 0.6
"""Of two of a kind that size or material tells apart: those in one colour"""
TWINS_ALIKE = 0.95
"""The same in scenes of twins"""
OCCLUSION_SHARE = 0.35
"""Of things that are placed behind another, as the camera sees it, after a tall one"""
TALL = 0.15
"""What hides things [m]"""


def random_scene(
    seed: int,
    assets: tuple[Asset, ...] | None = None,
    paper_share: float = PAPER_SHARE,
    twins_share: float = 0.0,
) -> Scene:
    """Return the scene of a seed.

    Args:
        seed: Of all chance.
        assets: The scene is made of these only, so that a model can be reused.
        paper_share: Of scenes that are arranged like the paper's scene of their seed.
        twins_share: Of the other scenes: nothing but twins, two of a kind in one colour that are of
            other materials or sizes. A scene without twins is the same whatever this is.
    """
    rng = np.random.default_rng([seed, 1])
    judging = is_judging(seed)
    if assets is None:
        assets = random_assets(
            np.random.default_rng([seed, 2]), judging=judging, paper_scene=paper_scene_of(seed)
        )
    paper_scene: PaperScene | None = paper_scene_of(seed) if rng.random() < paper_share else None
    if paper_scene is not None and not has_things_of(paper_scene, assets):
        paper_scene = "a"
    stage = draw_stage(rng, assets, paper_scene, judging=judging)
    placed_kinds = {item.kind for item in stage.furniture}
    stock = tuple(
        asset
        for asset in assets
        if asset.kind not in placed_kinds and not (asset.for_paper and paper_scene is None)
    )
    wanted = () if paper_scene is None else PAPER_KINDS[paper_scene]
    chosen = _choose(rng, stock, stage.name, wanted)
    one_colour = ALIKE
    own = np.random.default_rng([seed, 3])
    if paper_scene is None and own.random() < twins_share:
        twins = _twins(own, stock, len(chosen))
        if twins:
            chosen, one_colour = twins, TWINS_ALIKE
    if paper_scene is not None and rng.random() < PAPER_ONLY_SHARE:
        first = {asset.kind: asset for asset in reversed(chosen)}
        chosen = [first[kind] for kind in wanted if kind in first]
        colours = _colours(rng, chosen, judging, one_colour)
        colours = [PAPER_COLOURS.get(a.kind, c) for a, c in zip(chosen, colours, strict=True)]
    else:
        colours = _colours(rng, chosen, judging, one_colour)
    arranger = Arranger(rng, stage.surfaces)
    tall: Placed | None = None
    for asset, colour in zip(chosen, colours, strict=True):
        region = stage.regions.get(asset.kind)
        hidden = tall if region is None and rng.random() < OCCLUSION_SHARE else None
        placed = arranger.put(asset, colour, region=region, behind=hidden)
        if placed is not None and placed.top - placed.foot > TALL:
            tall = placed
        elif hidden is not None:
            tall = None
    return Scene(
        name=f"random_{seed}",
        seed=seed,
        objects=(*stage.furniture, *(placed.item for placed in arranger.placed)),
        lights=_lights(rng),
        surroundings=_surroundings(rng),
    )


def _choose(
    rng: np.random.Generator, stock: tuple[Asset, ...], stage: str, wanted: tuple[str, ...]
) -> list[Asset]:
    """Return four to ten things, more in clutter, the wanted kinds first; often two of a kind."""
    movable = [asset for asset in stock if not KINDS[asset.kind].furniture]
    order = [movable[i] for i in rng.permutation(len(movable))]
    cluttered = rng.random() < CLUTTERED_SHARE
    count = int(rng.integers(11, 19) if cluttered else rng.integers(4, 11))
    if stage == "floor":
        # Things for the floor first, a few others between them.
        order.sort(key=lambda asset: not KINDS[asset.kind].floor and rng.random() < 0.75)
    first = list(wanted)
    if rng.random() < PAIR_SHARE:
        first += [str(rng.choice([asset.kind for asset in order[: 2 * count]]))] * 2
    chosen: list[Asset] = []
    for kind in first:
        same = [asset for asset in order if asset.kind == kind and asset not in chosen]
        chosen += same[:1]
    return (chosen + [asset for asset in order if asset not in chosen])[:count]


def _twins(rng: np.random.Generator, stock: tuple[Asset, ...], count: int) -> list[Asset]:
    """Return up to `count` things, two of each kind, that differ in material or size."""
    movable = [asset for asset in stock if not KINDS[asset.kind].furniture]
    pairs = [
        (one, other)
        for one, other in combinations(movable, 2)
        if one.kind == other.kind
        and (one.material != other.material or of_other_size(one.size, other.size))
    ]
    order = [pairs[i] for i in rng.permutation(len(pairs))]
    # Materials are harder to tell apart than sizes, and fewer pairs have them.
    order.sort(key=lambda pair: pair[0].material == pair[1].material and rng.random() < 0.5)
    return [asset for pair in order for asset in pair][: max(2, count)]


def _colours(
    rng: np.random.Generator, chosen: list[Asset], judging: bool, one_colour: float
) -> list[str]:
    """Return a colour for each thing.

    Two of a kind never have the same, unless their size or material tells them apart; `one_colour`
    is the share of those that have.
    """
    taken: list[tuple[Asset, str]] = []
    for asset in chosen:
        alike = [(other, c) for other, c in taken if other.kind == asset.kind]
        if alike and all(_differ(asset, *other) for other in alike) and rng.random() < one_colour:
            taken.append((asset, alike[0][1]))
            continue
        used = {c for _, c in alike}
        allowed = [c for c in KINDS[asset.kind].colours if c not in used]
        reserved = [c for c in allowed if held_out(asset.kind, c)]
        known = [c for c in allowed if c not in reserved]
        special = judging and reserved and (not known or rng.random() < 0.5)
        taken.append((asset, str(rng.choice(reserved if special else known))))
    return [colour for _, colour in taken]


def _differ(a: Asset, b: Asset, colour: str) -> bool:
    """Whether size or material tells two of a kind apart that are both of this colour."""
    return of_other_size(a.size, b.size) or tells_apart(a.kind, a.material, b.material, colour)


def _lights(rng: np.random.Generator) -> tuple[Light, ...]:
    """Return two lamps: one that may cast shadows, a weaker one from another side."""
    turn = rng.uniform(-np.pi, np.pi)
    lamps: list[Light] = []
    for angle, brightness in (
        (turn, rng.uniform(0.4, 0.8)),
        (turn + rng.uniform(1.5, 4.5), rng.uniform(0.1, 0.4)),
    ):
        flat = rng.uniform(0.3, 0.9)
        direction = (float(flat * np.cos(angle)), float(flat * np.sin(angle)), -1.0)
        position = (0.7 - 2.6 * direction[0], -2.6 * direction[1], 3.2)
        lamps.append(
            Light(
                position=position,
                direction=direction,
                brightness=float(brightness),
                warmth=float(rng.uniform(-1, 1)),
                shadow=not lamps,
            )
        )
    return tuple(lamps)


def _surroundings(rng: np.random.Generator) -> Surroundings:
    # As Python's own text: a scene file takes no other.
    floor = rng.choice(["tiles", "wood", "concrete", "carpet"]).item()
    colour = shade(COLOURS[str(rng.choice(["grey", "white", "brown", "blue", "green"]))], rng, 0.15)
    pale = 0.35 + 0.6 * np.asarray(colour)
    wall = np.clip(rng.uniform(0.5, 0.95) + rng.uniform(-0.08, 0.08, 3), 0, 1)
    return Surroundings(
        floor=floor,
        floor_colour=(float(pale[0]), float(pale[1]), float(pale[2])),
        wall_colour=(float(wall[0]), float(wall[1]), float(wall[2])),
        ambient=float(rng.uniform(0.28, 0.5)),
        variant=int(rng.integers(1_000_000)),
    )
