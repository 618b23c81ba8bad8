"""Pictures of random scenes with the truth about them, for training and for judging."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import groupby
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from w2c.geometry import intrinsics_from_fov
from w2c.workers import end_with_parent
from w2c_sim_robot.scenes.assets import SCENES_PER_STOCK
from w2c_sim_robot.scenes.held_out import HELD_OUT_KINDS, held_out, held_out_material
from w2c_sim_robot.scenes.objects.catalogue import KINDS
from w2c_sim_robot.scenes.picture_set import PictureSet, SetDescription
from w2c_sim_robot.scenes.pool import Pool, Shot
from w2c_sim_robot.scenes.random_scene import random_scene
from w2c_sim_robot.scenes.scene import Scene, SceneObject
from w2c_sim_robot.scenes.wording import doubtful_words, parts_of, phrases_in

JPEG_QUALITY = 95
DEPTH_UNIT = 0.00025
"""Of depth pictures: 16-bit PNG [m]"""
SHADOW_SHARE = 0.3


def render(
    directory: Path,
    seed: int,
    count: int,
    description: SetDescription,
    *,
    resume: bool = False,
    jobs: int = 1,
) -> Iterator[Path]:
    """Write the pictures of seeds `seed` to `seed + count - 1`; yields the truth file of each.

    A picture depends on nothing but its seed and the description, so that a set can be continued,
    and made by `jobs` processes at once.

    Raises:
        ConfigError: the directory holds something else.
        W2CError: a file cannot be written, the disk is full.
    """
    files = PictureSet(directory, description)
    files.open(seed, count, resume=resume)
    numbers = range(seed, seed + count)
    if jobs == 1:
        yield from _render(files, numbers, resume)
        return
    # A block of seeds shares one compiled model: it goes to one process.
    blocks = [list(block) for _, block in groupby(numbers, lambda n: n // SCENES_PER_STOCK)]
    # Not forked: a graphics context does not survive it.
    spawn = get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=spawn, initializer=end_with_parent) as workers:
        try:
            waiting = [workers.submit(_render_block, files, block, resume) for block in blocks]
            for block in waiting:
                yield from block.result()
        finally:
            workers.shutdown(wait=False, cancel_futures=True)


def _render_block(files: PictureSet, numbers: Sequence[int], resume: bool) -> list[Path]:
    return list(_render(files, numbers, resume))


def _render(files: PictureSet, numbers: Sequence[int], resume: bool) -> Iterator[Path]:
    description = files.description
    pool: Pool | None = None
    block = -1
    try:
        for number in numbers:
            name = f"{number:07d}"
            if resume and files.has(name):
                yield files.truth_file(name)
                continue
            if pool is None or number // SCENES_PER_STOCK != block:
                if pool is not None:
                    pool.close()
                block = number // SCENES_PER_STOCK
                pool = Pool(block, description.width, description.height)
            scene = random_scene(
                number, pool.assets, description.paper_share, description.twins_share
            )
            rng = np.random.default_rng([number, 9])
            shot = pool.shoot(scene, rng, shadows=bool(rng.random() < SHADOW_SHARE))
            write(files, name, scene, shot)
            yield files.truth_file(name)
    finally:
        if pool is not None:
            pool.close()


def write(files: PictureSet, name: str, scene: Scene, shot: Shot) -> None:
    """Write a picture, `_identity.png`, `_depth.png` if asked, and last the truth file.

    Raises:
        W2CError: a file cannot be written.
    """
    suffix = files.description.picture
    picture = cv2.cvtColor(shot.image.rgb, cv2.COLOR_RGB2BGR)
    quality = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY] if suffix == "jpg" else []
    files.write(f"{name}.{suffix}", _encoded(f".{suffix}", picture, quality))
    files.write(f"{name}_identity.png", _encoded(".png", shot.identity))
    if files.description.depth:
        units = np.clip(shot.image.depth / DEPTH_UNIT + 0.5, 0, 65535).astype(np.uint16)
        files.write(f"{name}_depth.png", _encoded(".png", units))
    text = msgspec.json.format(msgspec.json.encode(truth(name, scene, shot, suffix)), indent=1)
    files.write(f"{name}.json", text + b"\n")


def _encoded(suffix: str, image: npt.NDArray[Any], options: list[int] | None = None) -> bytes:
    done, data = cv2.imencode(suffix, image, options or [])
    if not done:
        raise ValueError(f"no {suffix} of a picture of shape {image.shape}")
    return data.tobytes()


def truth(name: str, scene: Scene, shot: Shot, suffix: str = "png") -> dict[str, Any]:
    """Return what the truth file holds; docs/reference/scenes.md describes its fields."""
    height, width = shot.identity.shape
    intrinsics = intrinsics_from_fov(width, height, shot.vertical_fov)
    fitting = {item.name: phrases_in(item, scene.objects) for item in scene.objects}
    return {
        "image": f"{name}.{suffix}",
        "identity": f"{name}_identity.png",
        "width": width,
        "height": height,
        "seed": scene.seed,
        "intrinsics": list(intrinsics),
        "world_from_camera": shot.world_from_camera.tolist(),
        "objects": [
            _object_truth(number, item, shot, fitting)
            for number, item in enumerate(scene.objects, start=1)
        ],
    }


def _object_truth(
    number: int, item: SceneObject, shot: Shot, fitting: dict[str, tuple[str, ...]]
) -> dict[str, Any]:
    mask = shot.identity == number
    phrases = fitting[item.name]
    elsewhere = {text for name, texts in fitting.items() if name != item.name for text in texts}
    return {
        "id": number,
        "name": item.name,
        "kind": item.kind,
        "colour": item.colour,
        "material": item.material,
        "looks_like": list(doubtful_words(item)),
        "names": list(item.names),
        "phrases": list(phrases),
        "own_phrases": [phrase for phrase in phrases if phrase not in elsewhere],
        "held_out": held_out(item.kind, item.colour),
        "held_out_kind": item.kind in HELD_OUT_KINDS,
        "held_out_material": held_out_material(item.kind, item.material),
        "box": _box(mask),
        "visible_pixels": int(np.count_nonzero(mask)),
        "parts": [
            {"name": part, "box": _box(seen), "visible_pixels": int(np.count_nonzero(seen))}
            for part, seen in (
                (part, mask & (shot.parts == index))
                for index, part in enumerate(parts_of(item), start=1)
            )
        ],
        "position": list(item.position),
        "orientation": list(item.orientation),
        "size": list(item.size),
        "mass": item.mass,
        "movable": not KINDS[item.kind].furniture,
        "support": item.support,
    }


def _box(mask: npt.NDArray[np.bool_]) -> list[int] | None:
    """Return left, top, right, bottom of what a mask holds [px]; None where it is empty."""
    rows, columns = np.nonzero(mask)
    if not len(rows):
        return None
    return [int(columns.min()), int(rows.min()), int(columns.max()) + 1, int(rows.max()) + 1]
