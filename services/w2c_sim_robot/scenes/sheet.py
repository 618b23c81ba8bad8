"""Contact sheets: small labelled pictures of every kind, every scene, some random scenes."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from w2c.errors import ConfigError
from w2c.geometry import quaternion_from_rotation, unit
from w2c_sim_robot.camera.renderer import Renderer
from w2c_sim_robot.camera.studio import Studio
from w2c_sim_robot.model import ready_configuration
from w2c_sim_robot.scenes.assets import SCENES_PER_STOCK
from w2c_sim_robot.scenes.build import add_scene
from w2c_sim_robot.scenes.objects.catalogue import KINDS, make_object
from w2c_sim_robot.scenes.pool import Pool
from w2c_sim_robot.scenes.random_scene import random_scene
from w2c_sim_robot.scenes.scene import Light, Scene, SceneObject, Surroundings

Rgb = npt.NDArray[np.uint8]

TILE = (176, 144)
"""Of a kind: width, height [px]"""
SCENE_TILE = (400, 225)
CAPTION = 22
"""Height of the line under a picture [px]"""
SHEET_QUALITY = 82
FIELD_OF_VIEW = np.radians(24.0)
_LAMPS = (
    Light(position=(-2.0, 1.8, 3.0), direction=(0.5, -0.42, -0.76), brightness=0.66, warmth=0.15),
    Light(
        position=(1.0, -3.0, 2.0),
        direction=(-0.2, 0.75, -0.6),
        brightness=0.25,
        warmth=-0.2,
        shadow=False,
    ),
)
_BACKDROP = Surroundings(
    floor="concrete", floor_colour=(0.93, 0.93, 0.94), wall_colour=(0.97, 0.97, 0.98), ambient=0.42
)


def picture_of_kind(kind: str, size: tuple[int, int], *, material: str | None = None) -> Rgb:
    """Return one thing of a kind (h, w, 3), seen as the robot would, from a little to its left."""
    row = KINDS[kind]
    item = make_object(kind, row.colours[0], (0.0, 0.0, 0.0), variant=5, material=material)
    return _portrait(item, size)


def _portrait(item: SceneObject, size: tuple[int, int]) -> Rgb:
    spec = mujoco.MjSpec()
    spec.stat.extent, spec.stat.center = 2.0, (0.0, 0.0, 0.3)
    spec.visual.map.znear, spec.visual.map.zfar = 0.005, 20.0
    spec.visual.quality.shadowsize = 2048
    add_scene(spec, Scene(name="portrait", objects=(item,), lights=_LAMPS, surroundings=_BACKDROP))
    middle = np.array([0.0, 0.0, 0.5 * item.size[2]])
    radius = 0.5 * float(np.linalg.norm(item.size))
    away = 1.12 * radius / np.sin(FIELD_OF_VIEW / 2)
    back = unit(np.array([-1.0, 0.55, 0.75]))
    right = unit(np.cross((0.0, 0.0, 1.0), back))
    rotation = np.column_stack([right, np.cross(back, right), back])
    spec.worldbody.add_camera(
        name="portrait",
        pos=middle + away * back,
        quat=np.roll(quaternion_from_rotation(rotation), 1),
        fovy=float(np.degrees(FIELD_OF_VIEW)),
    )
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    renderer = Renderer(model, *size)
    try:
        return renderer.draw(data, "portrait", shadows=True, antialiasing=True).rgb
    finally:
        renderer.close()


def kinds_sheet(kinds: Sequence[str] = tuple(KINDS), columns: int = 10) -> Rgb:
    """Return every kind with its name, by group."""
    order = sorted(kinds, key=lambda kind: (KINDS[kind].group, kind))
    return arranged(((picture_of_kind(kind, TILE), kind) for kind in order), columns)


def picture_of_scene(scene: Scene, size: tuple[int, int], views: Sequence[str]) -> list[Rgb]:
    """Return the scene with the robot standing ready: `head`, `side`, `front`, `over_shoulder`."""
    studio = Studio(scene)
    try:
        studio.pose(ready_configuration(studio.model))
        return [studio.look(view, size) for view in views]
    finally:
        studio.close()


def scenes_sheet(scenes: Sequence[Scene]) -> Rgb:
    """Return each scene as the robot sees it, and from outside."""
    tiles = []
    for scene in scenes:
        views = ("head", "side")
        pictures = picture_of_scene(scene, SCENE_TILE, views)
        tiles += [
            (picture, f"{scene.name}, {view}")
            for picture, view in zip(pictures, views, strict=True)
        ]
    return arranged(iter(tiles), 2)


def random_sheet(seed: int, count: int, columns: int = 3) -> Rgb:
    """Return random scenes from a seed on, as `w2c scenes render` makes them."""
    pool = Pool(seed // SCENES_PER_STOCK, *SCENE_TILE)
    try:
        tiles = []
        for number in range(seed, seed + count):
            scene = random_scene(number, pool.assets)
            shot = pool.shoot(scene, np.random.default_rng([number, 9]), shadows=True)
            tiles.append((shot.image.rgb, f"seed {number}"))
        return arranged(iter(tiles), columns)
    finally:
        pool.close()


def arranged(pictures: Iterator[tuple[Rgb, str]], columns: int) -> Rgb:
    """Return pictures of one size side by side, each with a line of text below."""
    tiles = [_captioned(picture, text) for picture, text in pictures]
    if not tiles:
        raise ConfigError("a sheet of 0 pictures; ask for at least one")
    blank = np.full_like(tiles[0], 255)
    while len(tiles) % columns:
        tiles.append(blank)
    rows = [np.hstack(tiles[start : start + columns]) for start in range(0, len(tiles), columns)]
    return np.vstack(rows)


def _captioned(picture: Rgb, text: str) -> Rgb:
    height, width = picture.shape[:2]
    tile = np.full((height + CAPTION, width, 3), 255, np.uint8)
    tile[:height, : width - 2] = picture[:, : width - 2]
    font = cv2.FONT_HERSHEY_SIMPLEX
    cv2.putText(tile, text, (4, height + 16), font, 0.45, (30, 30, 30), 1, cv2.LINE_AA)
    return tile


def save_picture(picture: Rgb, path: Path) -> None:
    """Write a picture, JPEG or PNG by its name. Raises ConfigError where it cannot be written."""
    bgr = cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)
    if path.suffix not in (".jpg", ".png"):
        raise ConfigError(f"no picture can be written as '{path.suffix}'; use .jpg or .png")
    options = [cv2.IMWRITE_JPEG_QUALITY, SHEET_QUALITY] if path.suffix == ".jpg" else []
    _, encoded = cv2.imencode(path.suffix, bgr, options)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(encoded.tobytes())
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error}") from error
