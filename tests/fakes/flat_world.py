"""Scenes of low boxes seen straight from above, with the truth of `w2c scenes render`, drawn flat.

One pixel is the same length everywhere on a surface, so that areas can be measured by hand.
"""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

WIDTH, HEIGHT = 320, 180
FOCAL = 200.0
EYE = (1.0, 0.0, 2.0)
"""Of the camera, which looks down with the world's x up in the picture [m]"""
TABLE = 0.8
NAMES = {
    "book": ("book", "hardcover"),
    "mug": ("cup", "mug"),
    "box": ("box", "carton"),
    "toolbox": ("toolbox", "tool box"),
    "bottle": ("bottle", "flask"),
    "cloth": ("cloth", "towel", "rag"),
    "sponge": ("sponge",),
    "plate": ("plate", "dish"),
}
SUPPORT = {"book": "carries", "toolbox": "carries", "cloth": "carries", "mug": "fragile"}
COLOURS = {"red": (200, 30, 30), "green": (30, 160, 50), "blue": (30, 60, 200), "black": (20,) * 3}
UNSEEN_COLOUR = "green"
"""Of things of which it is said that no training shows them"""
TABLE_ID = 1


@dataclass(frozen=True)
class Lying:
    """A box: its kind and colour, where its middle is in the picture, and its extents [m]."""

    kind: str
    colour: str
    u: float
    v: float
    size: tuple[float, float, float] = (0.16, 0.16, 0.03)


def pixels_per_metre(height_m: float) -> float:
    """Return the scale of a level surface."""
    return FOCAL / (EYE[2] - height_m)


def picture_of(things: list[Lying], *, on_floor: bool = False) -> Any:
    """Return the picture and the truth of things on a table that fills it, or on the floor."""
    foot = 0.0 if on_floor else TABLE
    identity = np.full((HEIGHT, WIDTH), 0 if on_floor else TABLE_ID, np.uint8)
    depth = np.full((HEIGHT, WIDTH), EYE[2] - foot, np.float32)
    rgb = np.full((HEIGHT, WIDTH, 3), 200, np.uint8)
    objects = [] if on_floor else [_truth(TABLE_ID, Lying("table", "black", 160, 90), foot, None)]
    for number, thing in enumerate(things, len(objects) + 1):
        scale = pixels_per_metre(foot + thing.size[2])
        left, right = (round(thing.u + side * scale * thing.size[1] / 2) for side in (-1, 1))
        top, bottom = (round(thing.v + side * scale * thing.size[0] / 2) for side in (-1, 1))
        seen = slice(max(0, top), bottom), slice(max(0, left), right)
        identity[seen], rgb[seen] = number, COLOURS[thing.colour]
        depth[seen] = EYE[2] - foot - thing.size[2]
        objects.append(_truth(number, thing, foot, identity))
    _say_what_fits(objects)
    truth = {
        "intrinsics": [FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2],
        "world_from_camera": [
            [0.0, -1.0, 0.0, EYE[0]],
            [-1.0, 0.0, 0.0, EYE[1]],
            [0.0, 0.0, -1.0, EYE[2]],
            [0.0, 0.0, 0.0, 1.0],
        ],
        "objects": objects,
    }
    return SimpleNamespace(rgb=rgb, identity=identity, depth=depth, truth=truth)


class FlatWorld:
    """In the place of the simulator: eight things in two rows, some twice, some on the floor."""

    def __init__(self) -> None:
        self.drawn: list[tuple[int, bool]] = []

    def scene(self, seed: int) -> Any:
        """Return what is there, without a picture."""
        objects = [SimpleNamespace(kind=thing.kind, movable=True) for thing in self._things(seed)]
        table = [] if seed % 4 == 0 else [SimpleNamespace(kind="table", movable=False)]
        return SimpleNamespace(objects=[*table, *objects])

    def draw(self, seed: int, *, outdoors: bool) -> Any:
        """Return the picture."""
        self.drawn.append((seed, outdoors))
        return picture_of(self._things(seed), on_floor=seed % 4 == 0)

    def close(self) -> None:
        """Let go of nothing."""

    @staticmethod
    def _things(seed: int) -> list[Lying]:
        rng = np.random.default_rng(seed)
        kinds = [str(kind) for kind in rng.permutation(sorted(NAMES))[:7]]
        kinds.append(kinds[int(rng.integers(7))])
        colours = rng.permutation(np.repeat(sorted(COLOURS), 2))
        return [
            Lying(kind, str(colours[i]), 50 + 75 * (i % 4), 55 + 75 * (i // 4), (0.14, 0.14, 0.04))
            for i, kind in enumerate(kinds)
        ]


def _truth(number: int, thing: Lying, foot: float, identity: Any) -> dict[str, Any]:
    names = NAMES.get(thing.kind, (thing.kind,))
    rows, columns = np.nonzero(identity == number) if identity is not None else ([0], [0])
    scale = pixels_per_metre(foot)
    return {
        "id": number,
        "name": f"{thing.kind}_{number}",
        "kind": thing.kind,
        "colour": thing.colour,
        "material": "",
        "names": list(names),
        "phrases": [*names, *(f"{thing.colour} {name}" for name in names)],
        "own_phrases": [],
        "held_out": thing.colour == UNSEEN_COLOUR,
        "held_out_kind": thing.kind == "plate",
        "held_out_material": False,
        "box": [int(min(columns)), int(min(rows)), int(max(columns)) + 1, int(max(rows)) + 1],
        "visible_pixels": len(rows) if identity is not None else WIDTH * HEIGHT,
        "position": [
            EYE[0] - (thing.v - HEIGHT / 2) / scale, EYE[1] - (thing.u - WIDTH / 2) / scale, foot,
        ],
        "orientation": [0.0, 0.0, 0.0, 1.0],
        "size": list(thing.size),
        "movable": thing.kind != "table",
        "support": SUPPORT.get(thing.kind, "slides"),
    }  # fmt: skip


def _say_what_fits(objects: list[dict[str, Any]]) -> None:
    for item in objects:
        taken = {text for other in objects if other is not item for text in other["phrases"]}
        item["own_phrases"] = [text for text in item["phrases"] if text not in taken]
