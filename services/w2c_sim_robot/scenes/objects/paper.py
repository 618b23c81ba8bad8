"""Books, sheets and boxes."""

import numpy as np

from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.meshes import box, prism, rounded_rectangle
from w2c_sim_robot.scenes.objects.shape import (
    Mesh,
    Part,
    Shape,
    Size,
    Surface,
    box_collider,
    merged,
)

PAGES = (0.95, 0.91, 0.80)


def book(size: Size, rng: np.random.Generator) -> Shape:
    """Return a hardcover that lies flat, its spine to the left (+y)."""
    x, y, z = size
    board = min(0.004, 0.18 * z)
    edge = 0.005
    boards = _slab((x, y, board)), _slab((x, y, board)).moved((0, 0, z - board))
    spine = prism(rounded_rectangle(x, 0.008, 0.0035), z - 2 * board).moved(
        (0, y / 2 - 0.004, board)
    )
    block = box((x - 2 * edge, y - edge - 0.006, z - 2 * board), ("+x", "-x", "-y"))
    cover = box((x, y, z), ("+z",)).moved((0, 0, 3e-4))
    return Shape(
        (
            Part(merged(*boards, spine), Surface("main", gloss=0.35)),
            Part(
                block.moved((0, (edge - 0.006) / 2, board)),
                Surface(PAGES, textures.pages(rng), 0.05),
                "pages",
                "paper",
            ),
            Part(_inset(cover, 0.985), Surface("main", textures.cover(rng), 0.45), "cover"),
        ),
        (box_collider(size),),
    )


def notebook(size: Size, rng: np.random.Generator) -> Shape:
    """Return a ring-bound pad: a soft cover, a label, wire rings along the far edge."""
    x, y, z = size
    outline = rounded_rectangle(x, y, 0.008)
    rings = []
    for place in np.linspace(-0.42, 0.42, 18) * y:
        ring = prism(rounded_rectangle(0.014, 0.003, 0.001), z + 0.003)
        rings.append(ring.moved((x / 2 - 0.009, float(place), 0)))
    label = box((0.28 * x, 0.5 * y, 4e-4), ("+z",)).moved((0.1 * x, 0, z))
    return Shape(
        (
            Part(prism(outline, z * 0.86, 0.0006), Surface(PAGES, None, 0.05)),
            Part(
                prism(outline, z * 0.14, 0.0002).moved((0, 0, z * 0.86)),
                Surface("main", textures.weave(rng), 0.2),
            ),
            Part(merged(*rings), Surface((0.16, 0.16, 0.18), None, 0.8), "rings", "metal"),
            Part(label, Surface((0.97, 0.96, 0.92), textures.lines(rng, 96, 160, 24), 0.05)),
        ),
        (box_collider(size),),
    )


def paper(size: Size, rng: np.random.Generator) -> Shape:
    """Return one written sheet."""
    sheet = box(size, ("+z",))
    return Shape(
        (
            Part(sheet, Surface("main", textures.lines(rng), 0.02)),
            Part(box(size, ("+x", "-x", "+y", "-y")), Surface("main", None, 0.02)),
        ),
        (box_collider(size),),
    )


def cereal_box(size: Size, rng: np.random.Generator) -> Shape:
    """Return an upright packet with a printed front and back."""
    faces = box(size, ("-x", "+x"))
    sides = box(size, ("-y", "+y", "+z", "-z"))
    front = textures.label(rng, 384, 512, stripe=None)[:, :256]
    return Shape(
        (
            Part(faces, Surface("main", front, 0.3), "front"),
            Part(sides, Surface("main", textures.speckle(rng), 0.3)),
        ),
        (box_collider(size),),
    )


def carton(size: Size, rng: np.random.Generator) -> Shape:
    """Return a closed box with tape across its lid."""
    x, y, z = size
    tape = box((0.9995 * x, 0.16 * y, z + 6e-4), ("+z",))
    flaps = [box((x, 0.004, 0.3 * z), (side,)).moved((0, 0, 0.7 * z)) for side in ("+x", "-x")]
    return Shape(
        (
            Part(
                prism(rounded_rectangle(x, y, 0.004), z, 0.002),
                Surface("main", textures.cardboard(rng), 0.08),
            ),
            Part(merged(tape, *flaps), Surface((0.80, 0.68, 0.46), None, 0.5)),
        ),
        (box_collider(size),),
    )


def _slab(size: Size) -> Mesh:
    return prism(rounded_rectangle(size[0], size[1], 0.004), size[2], 0.0008)


def _inset(mesh: Mesh, share: float) -> Mesh:
    return Mesh(mesh.vertices * [share, share, 1.0], mesh.normals, mesh.texcoords, mesh.faces)
