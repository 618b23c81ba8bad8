"""Every kind of object: its shape fills its size, compiles, and rests where it was put."""

import mujoco
import numpy as np
import pytest

from w2c.errors import ConfigError
from w2c_sim_robot.scenes.build import add_object, add_scene
from w2c_sim_robot.scenes.objects import meshes
from w2c_sim_robot.scenes.objects.catalogue import (
    KINDS,
    MOVABLE_KINDS,
    make_object,
    random_size,
    shape_of,
)
from w2c_sim_robot.scenes.objects.materials import FINISHES, PRINTED
from w2c_sim_robot.scenes.objects.palette import COLOURS, contrasting, shade
from w2c_sim_robot.scenes.objects.shape import Mesh, Shape, Size, Surface, bounds
from w2c_sim_robot.scenes.scene import Light, Scene
from w2c_sim_robot.scenes.wording import parts_of

LAMP = Light(position=(0.0, 0.0, 3.0), direction=(0.0, 0.0, -1.0))


@pytest.fixture(scope="module")
def shapes() -> dict[str, tuple[Size, Shape]]:
    """Return one of each kind, of a size by chance."""
    rng = np.random.default_rng(1)
    sizes = {kind: random_size(kind, rng) for kind in KINDS}
    return {
        kind: (size, shape_of(make_object(kind, row.colours[0], (0, 0, 0), size=size, variant=4)))
        for (kind, row), size in zip(KINDS.items(), sizes.values(), strict=True)
    }


def test_there_are_enough_kinds_each_in_several_colours() -> None:
    assert len(KINDS) >= 50
    assert len({row.group for row in KINDS.values()}) >= 9
    assert {row.support for row in KINDS.values()} == {"carries", "slides", "fragile", "forbidden"}
    assert all(len(row.colours) >= 3 and set(row.colours) <= set(COLOURS) for row in KINDS.values())


def test_materials_are_known_and_none_is_named_twice() -> None:
    for kind, row in KINDS.items():
        assert len(set(row.materials)) == len(row.materials), kind
        assert set(row.materials) - {""} <= set(FINISHES), kind


@pytest.mark.parametrize("kind", KINDS)
def test_a_shape_fills_the_size_it_was_asked_for(
    kind: str, shapes: dict[str, tuple[Size, Shape]]
) -> None:
    size, shape = shapes[kind]

    low, high = bounds(shape)

    assert low[2] == pytest.approx(0.0, abs=2e-3)
    assert high[2] == pytest.approx(size[2], abs=0.06 * size[2] + 3e-3)
    assert (high[:2] - low[:2] <= np.array(size[:2]) * 1.12 + 5e-3).all()
    assert (high[:2] - low[:2] >= 0.92 * min(size[:2])).all()


@pytest.mark.parametrize("kind", KINDS)
def test_colliders_stay_within_what_is_seen(
    kind: str, shapes: dict[str, tuple[Size, Shape]]
) -> None:
    _, shape = shapes[kind]
    low, high = bounds(shape)
    for collider in shape.colliders:
        half = np.array(
            collider.size
            if collider.shape == "box"
            else (collider.size[0], collider.size[0], collider.size[-1])
        )
        assert (collider.position - half >= low - 0.012).all()
        assert (collider.position + half <= high + 0.012).all()


@pytest.mark.parametrize("kind", KINDS)
def test_normals_have_length_one_and_look_outwards(
    kind: str, shapes: dict[str, tuple[Size, Shape]]
) -> None:
    for part in shapes[kind][1].parts:
        mesh = part.mesh
        assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(1.0, abs=1e-6)
        assert _agreement(mesh) > 0.98


def test_things_stay_where_they_were_put(shapes: dict[str, tuple[Size, Shape]]) -> None:
    """All of them on one floor, an arm's length apart."""
    spec = mujoco.MjSpec()
    side = int(np.ceil(np.sqrt(len(MOVABLE_KINDS))))
    items = [
        make_object(
            kind,
            KINDS[kind].colours[0],
            (float(number % side), float(number // side), 0.0),
            size=shapes[kind][0],
            yaw=0.4,
            variant=4,
        )
        for number, kind in enumerate(MOVABLE_KINDS)
    ]
    add_scene(spec, Scene(name="all", objects=tuple(items), lights=(LAMP,)))
    model = spec.compile()
    data = mujoco.MjData(model)

    mujoco.mj_step(model, data, 250)

    for item in items:
        assert model.body(item.name).mass[0] == pytest.approx(item.mass, rel=1e-6)
        moved = np.abs(data.body(item.name).xpos - item.position).max()
        upright = data.body(item.name).xmat.reshape(3, 3)[2, 2]
        assert moved < 5e-3 and upright > np.cos(np.radians(3)), (item.name, moved, upright)


@pytest.mark.parametrize(
    ("kind", "part"),
    [
        ("mug", "handle"),
        ("mallet", "handle"),
        ("pot", "lid"),
        ("toolbox", "lid"),
        ("teapot", "spout"),
        ("dishwasher", "door"),
    ],
)
def test_parts_that_people_speak_of_have_names(kind: str, part: str) -> None:
    assert part in parts_of(make_object(kind, KINDS[kind].colours[0], (0, 0, 0)))


def look_of(surface: Surface) -> tuple[object, ...]:
    texture = b"" if surface.texture is None else surface.texture.tobytes()
    return surface.paint, surface.gloss, surface.opacity, texture


def test_another_material_changes_the_look_but_not_the_shape_or_the_print() -> None:
    usual = shape_of(make_object("nail_box", "brown", (0, 0, 0)))
    wooden = shape_of(make_object("nail_box", "brown", (0, 0, 0), material="wood"))

    for a, b in zip(usual.parts, wooden.parts, strict=True):
        assert np.array_equal(a.mesh.vertices, b.mesh.vertices)
        kept = a.surface.paint != "main" or a.name in PRINTED
        assert (look_of(a.surface) == look_of(b.surface)) == kept
    with pytest.raises(ConfigError, match="nail box of leather; it may be of: cardboard, wood"):
        make_object("nail_box", "brown", (0, 0, 0), material="leather")


def test_a_fixed_thing_has_no_joint() -> None:
    spec = mujoco.MjSpec()
    add_object(spec, make_object("book", "red", (0.0, 0.0, 1.0), movable=False))

    model = spec.compile()

    assert (model.nq, model.nbody) == (0, 2)


def test_the_same_variant_gives_the_same_print() -> None:
    def print_of(variant: int) -> bytes:
        shape = shape_of(make_object("book", "red", (0, 0, 0), variant=variant))
        return b"".join(
            p.surface.texture.tobytes() for p in shape.parts if p.surface.texture is not None
        )

    assert print_of(5) == print_of(5)
    assert print_of(5) != print_of(6)


def test_a_shade_keeps_grey_grey_and_print_can_be_read() -> None:
    rng = np.random.default_rng(0)

    greys = np.array([shade(COLOURS["grey"], rng) for _ in range(50)])

    assert np.ptp(greys, axis=1).max() < 0.04
    for colour in COLOURS.values():
        assert abs(np.mean(contrasting(colour)) - np.mean(colour)) > 0.2


def test_a_box_shows_the_top_of_its_cover_away_from_the_robot() -> None:
    lid = meshes.box((0.2, 0.1, 0.05), ("+z",))

    far = lid.vertices[:, 0] > 0

    assert lid.texcoords[far, 1].tolist() == [0.0, 0.0]
    assert lid.texcoords[~far, 1].tolist() == [1.0, 1.0]
    # Read from the robot, left (+y) is the start of a line.
    left = lid.vertices[:, 1] > 0
    assert lid.texcoords[left, 0].tolist() == [0.0, 0.0]


def _agreement(mesh: Mesh) -> float:
    """Return the share of triangles whose winding agrees with their normals."""
    corners = mesh.vertices[mesh.faces]
    winding = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.mean(np.einsum("ij,ij->i", winding, mesh.normals[mesh.faces].sum(axis=1)) > 0))


def test_a_plate_is_hollow_for_physics_too(shapes: dict[str, tuple[Size, Shape]]) -> None:
    """A hand that stops before the middle of a plate must not touch air."""
    size, shape = shapes["plate"]
    radius, height = size[1] / 2, size[2]
    for collider in shape.colliders:
        away = float(np.hypot(*collider.position[:2]))
        if away < 0.6 * radius:
            assert collider.position[2] + collider.size[-1] <= 0.32 * height
        else:
            assert away - collider.size[0] > 0.7 * radius
