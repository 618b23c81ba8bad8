"""Textures by arithmetic: wood, cloth, print. Grey: the surface's colour paints them."""

from itertools import pairwise

import cv2
import numpy as np
import numpy.typing as npt

from w2c_sim_robot.scenes.objects.palette import Colour
from w2c_sim_robot.scenes.objects.shape import Texture

Field = npt.NDArray[np.float64]


def _to_texture(field: Field) -> Texture:
    """Return an RGB texture of a field (h, w) or (h, w, 3) from 0 to 1."""
    rgb = field if field.ndim == 3 else np.repeat(field[:, :, None], 3, axis=2)
    return np.clip(rgb * 255.0 + 0.5, 0, 255).astype(np.uint8)


def noise(
    rng: np.random.Generator, height: int, width: int, grain: float, octaves: int = 4
) -> Field:
    """Return smooth noise (h, w), mean 0, deviation 1; `grain` = its largest spots [px]."""
    total = np.zeros((height, width))
    for octave in range(octaves):
        spot = max(grain / 2**octave, 1.0)
        small = rng.standard_normal((max(2, round(height / spot)), max(2, round(width / spot))))
        total += cv2.resize(small, (width, height), interpolation=cv2.INTER_CUBIC) / 2**octave
    return np.asarray((total - total.mean()) / (total.std() + 1e-9))


def wood(rng: np.random.Generator, height: int = 512, width: int = 512, planks: int = 4) -> Texture:
    """Return light grey wood: planks along the rows, each with its own grain and tone."""
    result = np.zeros((height, width))
    edges = np.linspace(0, height, planks + 1).astype(int)
    for top, bottom in pairwise(edges):
        rows = bottom - top
        across = np.linspace(0, rng.uniform(5, 9), rows)[:, None]
        wave = cv2.resize(noise(rng, rows, 64, 30), (width, rows), interpolation=cv2.INTER_CUBIC)
        rings = 0.5 + 0.5 * np.sin(2 * np.pi * (across + 0.55 * wave + rng.uniform(0, 9)))
        fibre = cv2.resize(rng.standard_normal((rows, max(8, width // 24))), (width, rows))
        plank = 0.86 + 0.045 * rng.standard_normal() - 0.13 * rings**3 + 0.035 * fibre
        plank[:1] *= 0.72
        result[top:bottom] = plank
    return _to_texture(result)


def speckle(
    rng: np.random.Generator, amount: float = 0.03, grain: float = 24.0, size: int = 128
) -> Texture:
    """Return almost white with soft spots: plaster, cardboard, glaze."""
    return _to_texture(
        0.95
        + amount * noise(rng, size, size, grain)
        + 0.4 * amount * rng.standard_normal((size, size))
    )


def cardboard(rng: np.random.Generator, size: int = 256) -> Texture:
    """Return cardboard with faint flutes, a strip of tape across and a printed arrow."""
    field = 0.9 + 0.02 * noise(rng, size, size, 40) + 0.012 * np.sin(np.arange(size) * 1.1)[None, :]
    image = _to_texture(field)
    middle = size // 2
    image[middle - 20 : middle + 20] = (image[middle - 20 : middle + 20] * 0.93 + 14).astype(
        np.uint8
    )
    return image


def weave(rng: np.random.Generator, size: int = 256, stripes: int = 0) -> Texture:
    """Return woven cloth, with darker stripes near two of its edges where `stripes` > 0."""
    rows, columns = np.mgrid[0:size, 0:size]
    threads = 0.045 * np.sin(rows * 2 * np.pi / 4) * np.sin(columns * 2 * np.pi / 4)
    field = 0.92 + threads + 0.03 * noise(rng, size, size, 70)
    for stripe in range(stripes):
        for start in (18 + 14 * stripe, size - 26 - 14 * stripe):
            field[start : start + 8] *= 0.62
    return _to_texture(field)


def rings(rng: np.random.Generator, height: int = 256, bands: int = 3, width: int = 64) -> Texture:
    """Return white with darker bands across: the print of a mug or of a ball."""
    field = np.full((height, width), 0.97) + 0.01 * noise(rng, height, width, 30)
    for _ in range(bands):
        start = int(rng.uniform(0.12, 0.8) * height)
        field[start : start + int(rng.uniform(0.03, 0.1) * height)] *= rng.uniform(0.45, 0.8)
    return _to_texture(field)


def cover(rng: np.random.Generator, height: int = 384, width: int = 288) -> Texture:
    """Return the cover of a book: frame, title, emblem and author in darker print."""
    field = 0.96 + 0.015 * noise(rng, height, width, 50)
    ink = rng.uniform(0.25, 0.5)
    if rng.random() < 0.6:
        margin = int(0.05 * width)
        cv2.rectangle(field, (margin, margin), (width - margin, height - margin), ink, 3)
    top = int(rng.uniform(0.12, 0.2) * height)
    for _ in range(int(rng.integers(2, 4))):
        length = rng.uniform(0.4, 0.7) * width
        _printed_line(field, rng, (top, int(0.075 * height)), (width / 2 - length / 2, length), ink)
        top += int(0.11 * height)
    centre = (width // 2, int(0.64 * height))
    radius = int(rng.uniform(0.12, 0.2) * width)
    if rng.random() < 0.5:
        cv2.circle(field, centre, radius, ink, -1, cv2.LINE_AA)
        cv2.circle(field, centre, int(0.6 * radius), 0.9, 4, cv2.LINE_AA)
    else:
        points = np.array(centre) + radius * np.array([[0, -1.2], [1.0, 0.7], [-1.0, 0.7]])
        cv2.fillConvexPoly(field, points.astype(np.int32), ink, cv2.LINE_AA)
    _printed_line(
        field, rng, (int(0.86 * height), int(0.035 * height)), (0.3 * width, 0.4 * width), ink
    )
    return _to_texture(field)


def _printed_line(
    field: Field,
    rng: np.random.Generator,
    rows: tuple[int, int],
    columns: tuple[float, float],
    ink: float,
) -> None:
    """Draw a line of letters that cannot be read: bars, with gaps between words."""
    top, tall = rows
    start, length = columns
    x = start
    while x < start + length:
        wide = rng.uniform(0.35, 0.75) * tall
        if rng.random() < 0.85:
            cv2.rectangle(
                field, (int(x), top), (int(x + 0.7 * wide), top + int(tall * 0.8)), ink, -1
            )
        x += wide


def pages(rng: np.random.Generator, height: int = 48, width: int = 256) -> Texture:
    """Return the edge of a block of pages: fine lines along the rows."""
    lines = (
        0.9 + 0.06 * rng.standard_normal((height, 1)) + 0.015 * rng.standard_normal((height, width))
    )
    return _to_texture(lines)


def lines(
    rng: np.random.Generator, height: int = 384, width: int = 272, spacing: int = 16
) -> Texture:
    """Return a written page: ruled lines, and strokes of writing on the upper ones."""
    field = 0.97 + 0.008 * noise(rng, height, width, 60)
    written = rng.uniform(0.2, 0.9) * height
    for row in range(2 * spacing, height - spacing, spacing):
        field[row] *= 0.8
        if row < written:
            knots = np.arange(20, width - 20 - int(rng.uniform(0, 60)), 3)
            heights = row - 4 - np.abs(rng.normal(0, 3.2, len(knots)))
            cv2.polylines(
                field,
                [np.column_stack([knots, heights]).astype(np.int32)],
                False,
                0.35,
                1,
                cv2.LINE_AA,
            )
    return _to_texture(field)


def label(
    rng: np.random.Generator, height: int = 256, width: int = 512, stripe: Colour | None = None
) -> Texture:
    """Return the label of a can, bottle or packet: a panel with a made-up brand, twice around."""
    image = np.full((height, width, 3), 0.97)
    band = np.asarray(stripe if stripe is not None else (0.45, 0.45, 0.45))
    low, high = int(rng.uniform(0.08, 0.2) * height), int(rng.uniform(0.8, 0.92) * height)
    image[low : low + 10] = image[high - 10 : high] = band
    for half in (0, width // 2):
        centre = (half + width // 4, height // 2)
        axes = (int(rng.uniform(0.13, 0.19) * width), int(rng.uniform(0.2, 0.28) * height))
        cv2.ellipse(
            image, centre, axes, rng.uniform(-15, 15), 0, 360, tuple(band * 0.9), -1, cv2.LINE_AA
        )
        cv2.ellipse(
            image, centre, (axes[0] - 8, axes[1] - 8), 0, 0, 360, (0.98, 0.96, 0.9), 3, cv2.LINE_AA
        )
        grey = np.ascontiguousarray(image[:, :, 0])
        mask = np.ones_like(grey)
        _printed_line(
            mask, rng, (height // 2 - 16, 36), (centre[0] - axes[0] * 0.7, axes[0] * 1.4), 0.0
        )
        image[mask < 0.5] = (0.98, 0.96, 0.9)
    return _to_texture(image)


def tiles(rng: np.random.Generator, size: int = 512, count: int = 4) -> Texture:
    """Return square floor tiles with grout between them."""
    field = 0.93 + 0.015 * noise(rng, size, size, 60)
    step = size // count
    for row in range(count):
        for column in range(count):
            field[row * step : (row + 1) * step, column * step : (column + 1) * step] *= (
                rng.uniform(0.95, 1.03)
            )
    for line in range(0, size, step):
        field[line : line + 4] = 0.7
        field[:, line : line + 4] = 0.7
    return _to_texture(field)


def concrete(rng: np.random.Generator, size: int = 512) -> Texture:
    """Return poured concrete."""
    return _to_texture(
        0.88 + 0.035 * noise(rng, size, size, 150, 7) + 0.02 * rng.standard_normal((size, size))
    )


def brushed(rng: np.random.Generator, size: int = 128) -> Texture:
    """Return metal: bands of light along the rows, as a room is mirrored in it, and streaks."""
    across = np.arange(size) / size
    field = np.full((size, size), 0.76)
    field += 0.02 * cv2.resize(rng.standard_normal((size, 6)), (size, size))
    for count, amount in ((3, 0.09), (5, 0.135), (8, 0.09)):
        field += amount * np.sin(2 * np.pi * (count * across + rng.uniform()))
    return _to_texture(field)


def wicker(rng: np.random.Generator, size: int = 192, count: int = 12) -> Texture:
    """Return plaited stems, over and under in turns."""
    rows, columns = np.mgrid[0:size, 0:size] * (count / size)
    over = (np.floor(rows) + np.floor(columns)) % 2
    across = np.sin(np.pi * (rows % 1.0))
    along = np.sin(np.pi * (columns % 1.0))
    field = 0.55 + 0.4 * np.where(over > 0, across, along)
    return _to_texture(field + 0.03 * noise(rng, size, size, 30))


def leather(rng: np.random.Generator, size: int = 192) -> Texture:
    """Return leather: creases."""
    creases = np.abs(noise(rng, size, size, 24, 2))
    return _to_texture(0.95 - 0.3 * np.exp(-9.0 * creases) + 0.02 * noise(rng, size, size, 60))


def stripes(rng: np.random.Generator, count: int = 6, size: int = 192) -> Texture:
    """Return knitted or woven stripes across."""
    rows = np.arange(size)[:, None] * count / size
    field = np.where(rows % 1.0 < 0.5, 0.96, rng.uniform(0.5, 0.8)) * np.ones((1, size))
    return _to_texture(field + 0.02 * noise(rng, size, size, 8, 2))


def words(
    lines_of_text: tuple[str, ...],
    size: tuple[int, int],
    *,
    ink: Colour = (0.15, 0.15, 0.15),
    ground: Colour = (0.97, 0.97, 0.97),
    boxed: Colour | None = None,
) -> Texture:
    """Return large print on a plain ground, `size` = (width, height) [px].

    With `boxed`, the lines stand on a panel of that colour.
    """
    width, height = size
    image = np.empty((height, width, 3), np.uint8)
    image[:] = _bytes(ground)
    font = cv2.FONT_HERSHEY_DUPLEX
    rows = height / (len(lines_of_text) + 0.5)
    if boxed is not None:
        low, high = (int(0.05 * width), int(0.18 * height)), (int(0.95 * width), int(0.82 * height))
        cv2.rectangle(image, low, high, _bytes(boxed), -1)
    for number, text in enumerate(lines_of_text):
        (wide, tall), _ = cv2.getTextSize(text, font, 1.0, 2)
        scale = min(0.88 * width / wide, 0.7 * rows / tall)
        left = int((width - scale * wide) / 2)
        foot = int((number + 0.75) * rows + 0.5 * scale * tall)
        thick = max(2, round(2.4 * scale))
        cv2.putText(image, text, (left, foot), font, scale, _bytes(ink), thick, cv2.LINE_AA)
    return image


def _bytes(colour: Colour) -> tuple[int, int, int]:
    red, green, blue = (round(255 * share) for share in colour)
    return red, green, blue


def grid(rows: int, columns: int, *, ink: float = 0.55, cell: int = 22) -> Texture:
    """Return light cells with gaps of `ink` between them: keys, tiles, the mesh of a grille."""
    field = np.full((rows * cell, columns * cell), ink)
    for row in range(rows):
        for column in range(columns):
            top, left = row * cell + 2, column * cell + 2
            field[top : top + cell - 4, left : left + cell - 4] = 0.97
    return _to_texture(field)


def brick_wall(rng: np.random.Generator, courses: int = 28, size: int = 1024) -> Texture:
    """Return painted brickwork: courses of bricks with joints between."""
    field = np.full((size, size), 0.8)
    tall = size // courses
    wide = 2.6 * tall
    for course in range(courses):
        start = -(course % 2) * wide / 2
        while start < size:
            left, right = max(int(start) + 3, 0), min(int(start + wide), size)
            if right > left:
                field[course * tall + 3 : (course + 1) * tall, left:right] = rng.uniform(0.9, 0.98)
            start += wide
    return _to_texture(field + 0.015 * noise(rng, size, size, 20))
