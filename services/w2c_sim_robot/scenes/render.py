"""Pictures of random scenes with the truth about them, for training and for judging."""

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np

from w2c.geometry import intrinsics_from_fov
from w2c_sim_robot.scenes.pool import SCENES_PER_POOL, Pool, Shot
from w2c_sim_robot.scenes.random_scene import PAPER_SHARE, held_out, random_scene
from w2c_sim_robot.scenes.scene import Scene, SceneObject

log = logging.getLogger("w2c.scenes")

JPEG_QUALITY = 95
DEPTH_UNIT = 0.00025
"""Of depth pictures: 16-bit PNG [m]"""
SHADOW_SHARE = 0.3


def render(
    directory: Path,
    seed: int,
    count: int,
    size: tuple[int, int],
    *,
    depth: bool = False,
    resume: bool = False,
    paper_share: float = PAPER_SHARE,
) -> Iterator[Path]:
    """Write the pictures of seeds `seed` to `seed + count - 1`; yields the truth file of each.

    A picture depends on nothing but its seed, size and share, so that a set can be continued.
    """
    directory.mkdir(parents=True, exist_ok=True)
    pool: Pool | None = None
    block = -1
    try:
        for number in range(seed, seed + count):
            truth_path = directory / f"{number:07d}.json"
            if resume and truth_path.exists():
                yield truth_path
                continue
            if pool is None or number // SCENES_PER_POOL != block:
                if pool is not None:
                    pool.close()
                block = number // SCENES_PER_POOL
                pool = Pool(block, *size)
            scene = random_scene(number, pool.assets, paper_share)
            rng = np.random.default_rng([number, 9])
            shot = pool.shoot(scene, rng, shadows=bool(rng.random() < SHADOW_SHARE))
            write(directory, f"{number:07d}", scene, shot, depth=depth)
            yield truth_path
    finally:
        if pool is not None:
            pool.close()


def write(directory: Path, name: str, scene: Scene, shot: Shot, *, depth: bool = False) -> None:
    """Write `<name>.jpg`, `_identity.png`, `_depth.png` if asked, and last `<name>.json`."""
    picture = cv2.cvtColor(shot.image.rgb, cv2.COLOR_RGB2BGR)
    cv2.imwrite(str(directory / f"{name}.jpg"), picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    cv2.imwrite(str(directory / f"{name}_identity.png"), shot.identity)
    if depth:
        units = np.clip(shot.image.depth / DEPTH_UNIT + 0.5, 0, 65535).astype(np.uint16)
        cv2.imwrite(str(directory / f"{name}_depth.png"), units)
    encoded = msgspec.json.format(msgspec.json.encode(truth(name, scene, shot)), indent=1)
    (directory / f"{name}.json").write_bytes(encoded + b"\n")


def truth(name: str, scene: Scene, shot: Shot) -> dict[str, Any]:
    """Return what the truth file holds; its fields are described in `w2c scenes render --help`."""
    height, width = shot.identity.shape
    intrinsics = intrinsics_from_fov(width, height, shot.vertical_fov)
    return {
        "image": f"{name}.jpg",
        "identity": f"{name}_identity.png",
        "width": width,
        "height": height,
        "seed": scene.seed,
        "intrinsics": list(intrinsics),
        "world_from_camera": shot.world_from_camera.tolist(),
        "objects": [
            _object_truth(number, item, shot) for number, item in enumerate(scene.objects, start=1)
        ],
    }


def _object_truth(number: int, item: SceneObject, shot: Shot) -> dict[str, Any]:
    rows, columns = np.nonzero(shot.identity == number)
    box = (
        [int(columns.min()), int(rows.min()), int(columns.max()) + 1, int(rows.max()) + 1]
        if len(rows)
        else None
    )
    return {
        "id": number,
        "name": item.name,
        "kind": item.kind,
        "colour": item.colour,
        "material": item.material,
        "names": list(item.names),
        "phrases": list(item.phrases()),
        "held_out": held_out(item.kind, item.colour),
        "box": box,
        "visible_pixels": len(rows),
        "position": list(item.position),
        "orientation": list(item.orientation),
        "size": list(item.size),
        "support": item.support,
    }
