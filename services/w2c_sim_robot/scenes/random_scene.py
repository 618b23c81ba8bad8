"""Scenes by chance: furniture, things on it, colours, light. Same seed, same scene."""

import zlib
from dataclasses import dataclass

import numpy as np

from w2c_sim_robot.scenes.objects.catalogue import (
    KINDS,
    MOVABLE_KINDS,
    make_object,
    random_size,
)
from w2c_sim_robot.scenes.objects.palette import COLOURS, shade
from w2c_sim_robot.scenes.objects.shape import Size
from w2c_sim_robot.scenes.scene import Light, Scene, SceneObject, Surroundings

JUDGING_SEED = 900_000
"""Scenes from this seed on are for judging: nothing is trained on them, and they alone show
held-out pairs."""
FLAT_KINDS = ("book", "box", "tray", "notebook", "cloth", "paper")
"""What smaller things may stand on"""
SMALL_KINDS = ("mug", "can", "ball", "apple", "sponge", "block", "bottle", "bowl")
Region = tuple[tuple[float, float], tuple[float, float]]
PAPER_REGIONS: dict[str, Region] = {
    "book": ((0.42, 0.60), (-0.40, -0.12)),
    "mug": ((0.95, 1.38), (-0.05, 0.32)),
}
"""Where the things of the paper's scene (a) stand: x and y [m]"""
PAPER_SHARE = 0.2
"""Of scenes with a book and a mug where the paper's scene (a) has them"""
PAPER_COLOURS = {"book": "red", "mug": "blue", "bottle": "green", "bowl": "yellow"}
"""What is in scene (a), and its colours; half of such scenes hold exactly these"""
GAP = 0.012
"""Between things that stand beside each other [m]"""


@dataclass(frozen=True)
class Asset:
    """A thing without its colour and place."""

    name: str
    kind: str
    size: Size
    variant: int


def held_out(kind: str, colour: str) -> bool:
    """Whether this pair is kept for judging: about one in seven, never all colours of a kind."""
    if KINDS[kind].furniture or colour == KINDS[kind].colours[0]:
        return False
    return zlib.crc32(f"{kind}/{colour}".encode()) % 7 == 0


def random_assets(rng: np.random.Generator, copies: int = 2) -> tuple[Asset, ...]:
    """Return `copies` things of each kind, and one of each kind of furniture."""
    assets = []
    for kind, row in KINDS.items():
        for number in range(1 if row.furniture else copies):
            variant = int(rng.integers(1_000_000))
            assets.append(Asset(f"{kind}_{number}", kind, random_size(kind, rng), variant))
    return tuple(assets)


def random_scene(
    seed: int, assets: tuple[Asset, ...] | None = None, paper_share: float = PAPER_SHARE
) -> Scene:
    """Return the scene of a seed; with `assets`, of these only, so that a model can be reused.

    `paper_share` of the scenes have book and mug where the paper's scene (a) has them.
    """
    rng = np.random.default_rng([seed, 1])
    stock = random_assets(np.random.default_rng([seed, 2])) if assets is None else assets
    judging = seed >= JUDGING_SEED
    furniture = _furniture(rng, stock)
    as_in_paper = rng.random() < paper_share
    chosen = _choose(rng, stock, tuple(PAPER_COLOURS) if as_in_paper else ())
    if as_in_paper and rng.random() < 0.5:
        chosen = [next(a for a in chosen if a.kind == kind) for kind in PAPER_COLOURS]
        colours = [PAPER_COLOURS[asset.kind] for asset in chosen]
    else:
        colours = _colours(rng, chosen, judging)
    placed: list[SceneObject] = []
    for asset, colour in zip(chosen, colours, strict=True):
        region = PAPER_REGIONS.get(asset.kind) if as_in_paper else None
        item = _place(rng, asset, colour, furniture, placed, region=region)
        if item is not None:
            placed.append(item)
    return Scene(
        name=f"random_{seed}",
        seed=seed,
        objects=(furniture, *placed),
        lights=_lights(rng),
        surroundings=_surroundings(rng),
    )


def _furniture(rng: np.random.Generator, stock: tuple[Asset, ...]) -> SceneObject:
    """Place a table or a counter before the robot."""
    kind = "table" if rng.random() < 0.7 else "counter"
    candidates = [asset for asset in stock if asset.kind == kind]
    asset = candidates[int(rng.integers(len(candidates)))]
    weights = np.array(
        [0.6, *[0.4 / (len(KINDS[kind].colours) - 1)] * (len(KINDS[kind].colours) - 1)]
    )
    colour = str(rng.choice(KINDS[kind].colours, p=weights))
    front = rng.uniform(0.22, 0.42)
    position = (front + asset.size[0] / 2, float(rng.uniform(-0.25, 0.25)), 0.0)
    return make_object(
        kind, colour, position, name=asset.name, size=asset.size, variant=asset.variant
    )


def _choose(
    rng: np.random.Generator, stock: tuple[Asset, ...], wanted: tuple[str, ...]
) -> list[Asset]:
    """Return four to ten things, the wanted kinds among them; often two of a kind."""
    movable = [asset for asset in stock if asset.kind in MOVABLE_KINDS]
    order = [movable[i] for i in rng.permutation(len(movable))]
    count = int(rng.integers(4, 11))
    first = list(wanted)
    if rng.random() < 0.45:
        first += [str(rng.choice(MOVABLE_KINDS))] * 2
    chosen: list[Asset] = []
    for kind in first:
        same = [asset for asset in order if asset.kind == kind and asset not in chosen]
        chosen += same[:1]
    return (chosen + [asset for asset in order if asset not in chosen])[:count]


def _colours(rng: np.random.Generator, chosen: list[Asset], judging: bool) -> list[str]:
    """Return a colour for each thing; two of a kind never have the same."""
    taken: set[tuple[str, str]] = set()
    result = []
    for asset in chosen:
        allowed = [c for c in KINDS[asset.kind].colours if (asset.kind, c) not in taken]
        reserved = [c for c in allowed if held_out(asset.kind, c)]
        known = [c for c in allowed if c not in reserved] or allowed
        colour = str(rng.choice(reserved if judging and reserved and rng.random() < 0.5 else known))
        taken.add((asset.kind, colour))
        result.append(colour)
    return result


def _place(
    rng: np.random.Generator,
    asset: Asset,
    colour: str,
    furniture: SceneObject,
    placed: list[SceneObject],
    *,
    region: Region | None,
) -> SceneObject | None:
    """Return the thing where there is room, sometimes on top of another; None without room."""
    yaw = float(rng.uniform(-np.pi, np.pi) if rng.random() < 0.5 else rng.normal(0.0, 0.35))
    if region is None and asset.kind in SMALL_KINDS and rng.random() < 0.25:
        for below in placed:
            fits = _radius(asset.size) < 0.55 * min(below.size[:2]) and below.kind in FLAT_KINDS
            occupied = any(
                other.position[2] > below.position[2] + 1e-6 and _near(other, below)
                for other in placed
            )
            if fits and not occupied:
                return _made(asset, colour, (*below.position[:2], _rest_height(below)), yaw)
    surface_x, surface_y, height = furniture.position[0], furniture.position[1], furniture.size[2]
    radius = _radius(asset.size)
    front, back = surface_x - furniture.size[0] / 2, surface_x + furniture.size[0] / 2
    low_x, high_x = max(0.46, front + radius), min(1.35, back - radius)
    half_y = min(0.75, furniture.size[1] / 2 - radius)
    for _ in range(40):
        if high_x <= low_x:
            return None
        x = float(rng.uniform(low_x, high_x))
        # The picture is wider far away.
        reach = 0.12 + 0.5 * x
        y = float(np.clip(rng.uniform(-reach, reach), surface_y - half_y, surface_y + half_y))
        if region is not None:
            x = min(float(rng.uniform(*region[0])), back - radius)
            y = float(np.clip(rng.uniform(*region[1]), surface_y - half_y, surface_y + half_y))
        item = _made(asset, colour, (x, y, height), yaw)
        if not any(_near(item, other) for other in placed):
            return item
    return None


def _made(
    asset: Asset, colour: str, position: tuple[float, float, float], yaw: float
) -> SceneObject:
    return make_object(
        asset.kind,
        colour,
        position,
        name=asset.name,
        size=asset.size,
        yaw=yaw,
        variant=asset.variant,
    )


def _rest_height(below: SceneObject) -> float:
    """Return the height [m] of what carries things: the floor of a tray, else the top."""
    share = {"tray": 0.15, "cloth": 0.6}.get(below.kind, 1.0)
    return below.position[2] + share * below.size[2]


def _radius(size: Size) -> float:
    return 0.5 * float(np.hypot(size[0], size[1]))


def _near(a: SceneObject, b: SceneObject) -> bool:
    distance = float(np.hypot(a.position[0] - b.position[0], a.position[1] - b.position[1]))
    return distance < _radius(a.size) + _radius(b.size) + GAP


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
    floor = rng.choice(["tiles", "wood", "concrete", "carpet"])
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
