"""Make a benchmark: draw scenes until every slot of the plan has a picture."""

import errno
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import msgspec
import numpy as np

from w2c.errors import ConfigError, W2CError
from w2c_evaluation.benchmark.drawing import captioned, encoded, sheet, tinted
from w2c_evaluation.benchmark.figures import Figures, figures_of, missed
from w2c_evaluation.benchmark.offers import LEAST_DISTRACTORS, Offer, has_twin, offer
from w2c_evaluation.benchmark.plan import Slot, plan
from w2c_evaluation.benchmark.record import (
    IMAGES,
    MANIFEST_FILE,
    MASKS,
    OVERLAYS,
    PROMPTS_FILE,
    NamedThing,
    Origin,
    Record,
)
from w2c_evaluation.benchmark.sight import Sight, sight_of

FORMAT = 1
FIRST_SCENE = 1_000_000
"""Apart from the scenes by which models are chosen during training (900000 to 999999)"""
SCENES_PER_BENCHMARK = 10_000
SCENES_PER_STOCK = 50
PICTURES_PER_STOCK = 8
"""Of one stock of things; more would show the same ones again and again"""
SHEET_FILE = "sheet.jpg"


class Pictures(Protocol):
    """The simulator's scenes and pictures (`w2c_sim_robot.scenes.true_pictures`)."""

    def scene(self, seed: int) -> Any:
        """Return the scene of a seed: with `objects`, of which each has `kind` and `movable`."""

    def draw(self, seed: int, *, outdoors: bool) -> Any:
        """Return its picture."""


class Manifest(msgspec.Struct, frozen=True, kw_only=True):
    """What a folder of `benchmark make` says of itself."""

    format: int = FORMAT
    seed: int
    width: int
    height: int
    figures: Figures
    missed: list[str]
    """Limits that it does not keep; none where it is as hard as it shall be"""


@dataclass(frozen=True)
class Made:
    """A slot that has its picture."""

    slot: Slot
    scene: int
    sight: Sight
    stage: str
    offer: Offer


def fill(pictures: Pictures, seed: int, count: int, *, unseen: bool = False) -> Iterator[Made]:
    """Yield a picture for each slot, in the order in which they are found.

    The same seed gives the same ones. `unseen` as for `offer`.

    Raises:
        ConfigError: the scenes of a seed were not enough.
    """
    open_slots = plan(count)
    first = FIRST_SCENE + SCENES_PER_BENCHMARK * seed
    scene, from_stock = first, 0
    while open_slots and scene < first + SCENES_PER_BENCHMARK:
        made = _try(pictures, scene, open_slots, unseen)
        if made is not None:
            open_slots.remove(made.slot)
            from_stock += 1
            yield made
        scene += 1
        if from_stock >= PICTURES_PER_STOCK or scene % SCENES_PER_STOCK == 0:
            scene, from_stock = -(-scene // SCENES_PER_STOCK) * SCENES_PER_STOCK, 0
    if open_slots:
        raise ConfigError(
            f"{len(open_slots)} of {count} prompts found no picture in the "
            f"{SCENES_PER_BENCHMARK} scenes of seed {seed}; ask for fewer, or another seed"
        )


def _try(pictures: Pictures, seed: int, open_slots: list[Slot], unseen: bool) -> Made | None:
    """Return the first open slot that a scene can fill; None where it fills none."""
    scene = pictures.scene(seed)
    fit = [slot for slot in open_slots if _may_fill(scene, slot)]
    if not fit:
        return None
    look = fit[0].look
    picture = pictures.draw(seed, outdoors=look == "outdoor")
    sight = sight_of(picture)
    tried: set[tuple[Any, ...]] = set()
    for slot in fit:
        like = (slot.position, slot.limb, slot.pair, slot.plain)
        if slot.look != look or like in tried:
            continue
        tried.add(like)
        found = offer(sight, slot, np.random.default_rng([seed, slot.number, 41]), unseen=unseen)
        if found is not None:
            return Made(slot, seed, sight, _stage(scene), found)
    return None


def _may_fill(scene: Any, slot: Slot) -> bool:
    """Say whether a scene has what a slot needs, as far as that is known without a picture."""
    kinds = [item.kind for item in scene.objects if item.movable]
    enough = len(kinds) > LEAST_DISTRACTORS + (slot.position == "relative")
    ground = slot.limb == "hand" or _stage(scene) == "floor"
    return enough and ground and (not slot.pair or len(set(kinds)) < len(kinds))


def _stage(scene: Any) -> str:
    first = scene.objects[0]
    return "floor" if first.movable else str(first.kind)


def record_of(made: Made) -> Record:
    """Return the line of the prompts."""
    name = f"{made.slot.number:03d}"
    found = made.offer
    things = tuple(
        NamedThing(words=naming.text, kind=thing.kind, box=tuple(map(float, thing.edges)))  # type: ignore[arg-type]
        for thing, naming in zip(found.things, found.names, strict=True)
    )
    plain = any(naming.how == "plain" for naming in found.names)
    clear = made.sight.clear()
    return Record(
        id=name,
        prompt=found.sentence.text,
        position=made.slot.position,
        image=f"{IMAGES}/{name}.jpg",
        mask=f"{MASKS}/{name}.png",
        px_per_cm=round(made.sight.pixels_per_cm(found.things[0]), 2),
        things=things,
        origin=Origin(
            scene=made.scene,
            look=made.slot.look,
            stage=made.stage,
            relation=found.relation,
            naming="plain" if plain else found.names[0].how,
            attribute=found.names[0].attribute,
            pair=any(has_twin(thing, clear) for thing in clear),
            distractors=found.distractors,
            verb=found.sentence.verb,
            end_effector=found.sentence.end_effector,
            task=found.sentence.task,
            held_out=any(thing.never_trained_on for thing in found.things),
        ),
    )


class Folder:
    """The files of a benchmark. The prompts and the manifest are written last."""

    def __init__(self, directory: Path, size: tuple[int, int]) -> None:
        """Make the folder. Raises ConfigError where it holds anything."""
        self._directory = directory
        self._size = size
        try:
            directory.mkdir(parents=True, exist_ok=True)
            if any(directory.iterdir()):
                raise ConfigError(
                    f"--out {directory} is not empty; a benchmark is made as a whole: choose "
                    "another folder, or empty this one"
                )
            for name in (IMAGES, MASKS, OVERLAYS):
                (directory / name).mkdir()
        except OSError as error:
            raise ConfigError(f"--out {directory} cannot be used: {error}") from error
        self._done: dict[int, tuple[Record, float]] = {}
        self._small: dict[int, Any] = {}

    def add(self, made: Made) -> None:
        """Write the files of a picture. Raises W2CError."""
        record = record_of(made)
        picture = np.ascontiguousarray(made.sight.rgb[:, :, ::-1])
        mask = made.offer.mask
        seen = captioned(tinted(picture, mask), [f"{record.id}  {record.prompt}"])
        self._write(record.image, encoded(".jpg", picture))
        self._write(record.mask, encoded(".png", mask.astype(np.uint8) * 255))
        self._write(f"{OVERLAYS}/{record.id}.jpg", encoded(".jpg", seen, 85))
        self._done[made.slot.number] = record, float(mask.mean())
        self._small[made.slot.number] = captioned(
            tinted(picture, mask), [f"{record.id}  {record.prompt}"], 400
        )

    def finish(self, seed: int) -> Manifest:
        """Write sheet, prompts and manifest. Raises W2CError."""
        order = sorted(self._done)
        records = [self._done[number][0] for number in order]
        shares = [self._done[number][1] for number in order]
        figures = figures_of(records, shares)
        manifest = Manifest(
            seed=seed,
            width=self._size[0],
            height=self._size[1],
            figures=figures,
            missed=missed(figures),
        )
        small = [self._small[number] for number in order]
        self._write(SHEET_FILE, encoded(".jpg", sheet(small), 85))
        lines = b"".join(msgspec.json.encode(record) + b"\n" for record in records)
        self._write(MANIFEST_FILE, msgspec.json.format(msgspec.json.encode(manifest)) + b"\n")
        self._write(PROMPTS_FILE, lines)
        return manifest

    def _write(self, name: str, data: bytes) -> None:
        path = self._directory / name
        try:
            path.write_bytes(data)
        except OSError as error:
            full = error.errno in (errno.ENOSPC, errno.EDQUOT)
            advice = "free some space, empty the folder and begin again" if full else "check --out"
            raise W2CError(f"{path} cannot be written: {error}; {advice}") from error
