"""What things stand on by chance: a piece of furniture, the furniture of the paper's, or the floor.

Scenes of the paper are not copied: their furniture has other sizes and colours, and a third of
those like (b) and (d) are mirrored, so that a model learns what a dishwasher is and not where it
was.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from w2c_sim_robot.scenes.assets import Asset, PaperScene
from w2c_sim_robot.scenes.dishes import standing_plate
from w2c_sim_robot.scenes.held_out import held_out
from w2c_sim_robot.scenes.objects.appliances import DOOR_SHARE, DOOR_TOP
from w2c_sim_robot.scenes.objects.catalogue import KINDS, make_object
from w2c_sim_robot.scenes.objects.room import shelf_heights
from w2c_sim_robot.scenes.placing import Region, Surface
from w2c_sim_robot.scenes.scene import SceneObject

STAGES = {"table": 0.5, "counter": 0.16, "shelf": 0.15, "floor": 0.19}
"""What things stand on, and how often"""
REGIONS: dict[PaperScene, dict[str, Region]] = {
    "a": {"book": ((0.42, 0.60), (-0.40, -0.12)), "mug": ((0.95, 1.38), (-0.05, 0.32))},
    "b": {},
    "c": {
        "mallet": ((0.45, 0.62), (-0.22, 0.05)),
        "nail_box": ((1.00, 1.32), (-0.05, 0.30)),
        "toolbox": ((0.85, 1.10), (-0.60, -0.35)),
        "screwdriver": ((0.58, 0.82), (0.22, 0.50)),
    },
    "d": {"cheez_it_box": ((0.95, 1.32), (0.02, 0.32))},
}
"""Where the things of the paper's scenes stand: x and y [m]; of (d) seen from the fridge"""
WHITE_SHARE = 0.6
"""Of counters and cloths in scenes like the paper's, where they are white"""
CLOTH_THICK = 0.004
DRAPED_SHARE = 0.75


@dataclass(frozen=True)
class Stage:
    """Furniture, what belongs to it, and where other things may be put."""

    name: str
    furniture: tuple[SceneObject, ...]
    """Most important first: over it the robot holds its hands"""
    surfaces: tuple[Surface, ...]
    regions: Mapping[str, Region] = field(default_factory=dict)
    """Where things of these kinds shall be"""


def draw_stage(
    rng: np.random.Generator,
    assets: tuple[Asset, ...],
    paper_scene: PaperScene | None,
    *,
    judging: bool,
) -> Stage:
    """Return a stage of these assets, like that of a scene of the paper where it is given."""
    if paper_scene == "b":
        return _dishwasher(rng, assets, judging)
    if paper_scene == "d":
        return _fridge(rng, assets)
    names = list(STAGES) if paper_scene is None else list(STAGES)[:2]
    weights = np.array([STAGES[name] for name in names])
    name = str(rng.choice(names, p=weights / weights.sum()))
    return _plain(rng, assets, name, {} if paper_scene is None else REGIONS[paper_scene])


def _plain(
    rng: np.random.Generator, assets: tuple[Asset, ...], name: str, regions: Mapping[str, Region]
) -> Stage:
    """Return the floor, or one piece of furniture before the robot."""
    if name == "floor":
        return Stage(name, (), (Surface((0.62, -1.1), (1.9, 1.1), 0.0),), regions)
    asset = _find(assets, name)
    deep, wide, _ = asset.size
    colour = _colour(rng, name)
    front = float(rng.uniform(0.5, 0.75) if name == "shelf" else rng.uniform(0.22, 0.42))
    middle = front + deep / 2, float(rng.uniform(-0.25, 0.25))
    item = _made(asset, colour, (*middle, 0.0))
    if name == "shelf":
        low = (front + 0.005, middle[1] - wide / 2 + 0.03)
        high = (front + deep - 0.005, middle[1] + wide / 2 - 0.03)
        lower, upper, top = shelf_heights(asset.size)
        boards = (
            Surface(low, high, float(top)),
            Surface(low, high, float(upper), float(top - upper) - 0.04),
            Surface(low, high, float(lower), float(upper - lower) - 0.04),
        )
        return Stage(name, (item,), boards, regions)
    return Stage(name, (item,), (_top(item),), regions)


def _dishwasher(rng: np.random.Generator, assets: tuple[Asset, ...], judging: bool) -> Stage:
    """Return a counter, beside it an open dishwasher, and plates in a rack on its door: (b)."""
    side = _side(rng)
    counter, machine, rack = (_find(assets, k) for k in ("counter", "dishwasher", "dish_rack"))
    edge = -side * float(rng.uniform(0.0, 0.18))
    front = float(rng.uniform(0.25, 0.40))
    worktop = _made(
        counter,
        _often_white(rng, "counter"),
        (front + counter.size[0] / 2, edge - side * counter.size[1] / 2, 0.0),
    )
    door = float(rng.uniform(0.70, 1.05))
    across = edge + side * (machine.size[1] / 2 + float(rng.uniform(0.0, 0.06)))
    rack_x = door + DOOR_SHARE * machine.size[0] / 2
    things = [
        worktop,
        _made(machine, _colour(rng, "dishwasher"), (door + machine.size[0] / 2, across, 0.0)),
        _made(rack, _colour(rng, "dish_rack"), (rack_x, across, DOOR_TOP)),
        *_plates(rng, assets, (rack_x, across), judging),
    ]
    return Stage("dishwasher", tuple(things), (_top(worktop),))


def _plates(
    rng: np.random.Generator,
    assets: tuple[Asset, ...],
    rack: tuple[float, float],
    judging: bool,
) -> list[SceneObject]:
    """Return the plates in stock, some of the time only one, in a rack about this place."""
    plates = [asset for asset in assets if asset.kind == "plate"]
    plates = [plates[i] for i in rng.permutation(len(plates))][: int(rng.integers(1, 3))]
    allowed = [c for c in KINDS["plate"].colours if judging or not held_out("plate", c)]
    # In half of them the red one of the paper is in front.
    colours = ["red", *(str(c) for c in rng.permutation([c for c in allowed if c != "red"]))]
    if rng.random() < 0.5:
        colours = colours[1:]
    x = rack[0] - float(rng.uniform(0.08, 0.14))
    found = []
    for asset, colour in zip(plates, colours, strict=False):
        place = (x, rack[1] + float(rng.uniform(-0.08, 0.08)))
        found.append(
            standing_plate(
                asset.name,
                colour,
                place,
                DOOR_TOP,
                size=asset.size,
                variant=asset.variant,
                material=asset.material,
            )
        )
        x += float(rng.uniform(0.10, 0.14))
    return found


def _fridge(rng: np.random.Generator, assets: tuple[Asset, ...]) -> Stage:
    """Return a low fridge, most often with a cloth over its front, beside a table: (d)."""
    side = _side(rng)
    fridge, cloth, table = (_find(assets, kind) for kind in ("fridge", "drape", "table"))
    front = float(rng.uniform(0.26, 0.36))
    across = -side * float(rng.uniform(0.28, 0.42))
    low = _made(fridge, _colour(rng, "fridge"), (front + fridge.size[0] / 2, across, 0.0))
    table_front = float(rng.uniform(0.45, 0.75))
    edge = across + side * (fridge.size[1] / 2 + float(rng.uniform(0.01, 0.10)))
    beside = _made(
        table,
        _colour(rng, "table"),
        (table_front + table.size[0] / 2, edge + side * table.size[1] / 2, 0.0),
    )
    regions = {
        kind: (xs, (min(side * y for y in ys), max(side * y for y in ys)))
        for kind, (xs, ys) in REGIONS["d"].items()
    }
    if rng.random() >= DRAPED_SHARE:
        return Stage("fridge", (low, beside), (_top(beside), _top(low)), regions)
    slack = max(0.0, (fridge.size[1] - cloth.size[1]) / 2)
    over = _made(
        cloth,
        _often_white(rng, "drape"),
        (
            front + cloth.size[0] / 2 - float(rng.uniform(0.02, 0.04)),
            across + float(rng.uniform(-slack, slack)),
            fridge.size[2] + CLOTH_THICK - cloth.size[2],
        ),
    )
    return Stage("fridge", (low, beside, over), (_top(beside),), regions)


def _find(assets: tuple[Asset, ...], kind: str) -> Asset:
    return next(asset for asset in assets if asset.kind == kind)


def _made(asset: Asset, colour: str, position: tuple[float, float, float]) -> SceneObject:
    return make_object(
        asset.kind,
        colour,
        position,
        name=asset.name,
        size=asset.size,
        variant=asset.variant,
        material=asset.material,
        movable=False,
    )


def _side(rng: np.random.Generator) -> float:
    """Return +1 most often: what the left hand reaches for is on the left."""
    return 1.0 if rng.random() < 0.65 else -1.0


def _colour(rng: np.random.Generator, kind: str) -> str:
    """Return a colour of furniture: most often the first."""
    colours = KINDS[kind].colours
    others = len(colours) - 1
    return str(rng.choice(colours, p=[0.6, *[0.4 / others] * others]))


def _often_white(rng: np.random.Generator, kind: str) -> str:
    return "white" if rng.random() < WHITE_SHARE else _colour(rng, kind)


def _top(item: SceneObject) -> Surface:
    """Return what of its top the robot sees and reaches."""
    (x, y, _), (deep, wide, tall) = item.position, item.size
    return Surface(
        (max(0.40, x - deep / 2), max(-0.78, y - wide / 2)),
        (min(1.45, x + deep / 2), min(0.78, y + wide / 2)),
        tall,
    )
