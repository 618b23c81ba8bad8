"""Scenes by chance: furniture or floor, things on it, colours, light. Same seed, same scene."""

import numpy as np

from w2c_sim_robot.scenes.assets import PAPER_KINDS, Asset, random_assets
from w2c_sim_robot.scenes.held_out import held_out, is_judging
from w2c_sim_robot.scenes.objects.catalogue import KINDS, make_object
from w2c_sim_robot.scenes.objects.palette import COLOURS, shade
from w2c_sim_robot.scenes.objects.room import shelf_heights
from w2c_sim_robot.scenes.placing import Arranger, Placed, Surface
from w2c_sim_robot.scenes.scene import Light, Scene, SceneObject, Surroundings
from w2c_sim_robot.scenes.wording import OTHER_SIZE_RATIO, length_of

STAGES = {"table": 0.5, "counter": 0.16, "shelf": 0.15, "floor": 0.19}
"""What things stand on, and how often"""
Region = tuple[tuple[float, float], tuple[float, float]]
PAPER_REGIONS: dict[str, Region] = {
    "book": ((0.42, 0.60), (-0.40, -0.12)),
    "mug": ((0.95, 1.38), (-0.05, 0.32)),
}
"""Where the things of the paper's scene (a) stand: x and y [m]"""
PAPER_SHARE = 0.2
"""Of scenes with a book and a mug where the paper's scene (a) has them"""
PAPER_COLOURS = dict(zip(PAPER_KINDS, ("red", "blue", "green", "yellow"), strict=True))
"""What is in scene (a), and its colours; half of such scenes hold exactly these"""
CLUTTERED_SHARE = 0.25
PAIR_SHARE = 0.45
"""Of scenes with two of a kind on purpose"""
OCCLUSION_SHARE = 0.35
"""Of things that are placed behind another, as the camera sees it, after a tall one"""
TALL = 0.15
"""What hides things [m]"""


def random_scene(
    seed: int, assets: tuple[Asset, ...] | None = None, paper_share: float = PAPER_SHARE
) -> Scene:
    """Return the scene of a seed; with `assets`, of these only, so that a model can be reused.

    `paper_share` of the scenes have book and mug where the paper's scene (a) has them.
    """
    rng = np.random.default_rng([seed, 1])
    judging = is_judging(seed)
    if assets is None:
        assets = random_assets(np.random.default_rng([seed, 2]), judging=judging)
    as_in_paper = rng.random() < paper_share
    stages = list(STAGES)[:2] if as_in_paper else list(STAGES)
    weights = np.array([STAGES[name] for name in stages])
    stage = str(rng.choice(stages, p=weights / weights.sum()))
    furniture, surfaces = _stage(rng, stage, assets)
    chosen = _choose(rng, assets, stage, PAPER_KINDS if as_in_paper else ())
    if as_in_paper and rng.random() < 0.5:
        chosen = [next(a for a in chosen if a.kind == kind) for kind in PAPER_KINDS]
        colours = [PAPER_COLOURS[asset.kind] for asset in chosen]
    else:
        colours = _colours(rng, chosen, judging)
    arranger = Arranger(rng, surfaces)
    tall: Placed | None = None
    for asset, colour in zip(chosen, colours, strict=True):
        region = PAPER_REGIONS.get(asset.kind) if as_in_paper else None
        hidden = tall if region is None and rng.random() < OCCLUSION_SHARE else None
        placed = arranger.put(asset, colour, region=region, behind=hidden)
        if placed is not None and placed.top - placed.foot > TALL:
            tall = placed
        elif hidden is not None:
            tall = None
    return Scene(
        name=f"random_{seed}",
        seed=seed,
        objects=(*furniture, *(placed.item for placed in arranger.placed)),
        lights=_lights(rng),
        surroundings=_surroundings(rng),
    )


def _stage(
    rng: np.random.Generator, stage: str, assets: tuple[Asset, ...]
) -> tuple[tuple[SceneObject, ...], tuple[Surface, ...]]:
    """Return a piece of furniture before the robot, and the surfaces that it offers."""
    if stage == "floor":
        return (), (Surface((0.62, -1.1), (1.9, 1.1), 0.0),)
    asset = next(asset for asset in assets if asset.kind == stage)
    deep, wide, tall = asset.size
    row = KINDS[stage]
    others = len(row.colours) - 1
    colour = str(rng.choice(row.colours, p=[0.6, *[0.4 / others] * others]))
    front = float(rng.uniform(0.5, 0.75) if stage == "shelf" else rng.uniform(0.22, 0.42))
    middle = front + deep / 2, float(rng.uniform(-0.25, 0.25))
    item = make_object(
        stage,
        colour,
        (*middle, 0.0),
        name=asset.name,
        size=asset.size,
        variant=asset.variant,
        material=asset.material,
    )
    if stage == "shelf":
        low = (front + 0.005, middle[1] - wide / 2 + 0.03)
        high = (front + deep - 0.005, middle[1] + wide / 2 - 0.03)
        lower, upper, top = shelf_heights(asset.size)
        return (item,), (
            Surface(low, high, float(top)),
            Surface(low, high, float(upper), float(top - upper) - 0.04),
            Surface(low, high, float(lower), float(upper - lower) - 0.04),
        )
    low = (max(0.40, front), max(-0.78, middle[1] - wide / 2))
    high = (min(1.45, front + deep), min(0.78, middle[1] + wide / 2))
    return (item,), (Surface(low, high, tall),)


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


def _colours(rng: np.random.Generator, chosen: list[Asset], judging: bool) -> list[str]:
    """Return a colour for each thing.

    Two of a kind never have the same, unless their size or material tells them apart.
    """
    taken: list[tuple[Asset, str]] = []
    for asset in chosen:
        alike = [(other, c) for other, c in taken if other.kind == asset.kind]
        if alike and all(_differ(asset, other) for other, _ in alike) and rng.random() < 0.6:
            taken.append((asset, alike[0][1]))
            continue
        used = {c for _, c in alike}
        allowed = [c for c in KINDS[asset.kind].colours if c not in used]
        reserved = [c for c in allowed if held_out(asset.kind, c)]
        known = [c for c in allowed if c not in reserved]
        special = judging and reserved and (not known or rng.random() < 0.5)
        taken.append((asset, str(rng.choice(reserved if special else known))))
    return [colour for _, colour in taken]


def _differ(a: Asset, b: Asset) -> bool:
    """Whether size or material tells two of a kind apart."""
    ratio = length_of(a.size) / length_of(b.size)
    return a.material != b.material or max(ratio, 1 / ratio) >= OTHER_SIZE_RATIO


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
