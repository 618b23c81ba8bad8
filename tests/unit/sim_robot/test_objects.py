"""Every kind of object: its shape fills its size, compiles, and rests where it was put."""

import mujoco
import numpy as np
import pytest

from w2c_sim_robot.scenes.build import add_object, add_scene
from w2c_sim_robot.scenes.objects import meshes
from w2c_sim_robot.scenes.objects.catalogue import (
    KINDS,
    MOVABLE_KINDS,
    make_object,
    random_size,
    shape_of,
)
from w2c_sim_robot.scenes.objects.palette import COLOURS, contrasting, shade
from w2c_sim_robot.scenes.objects.shape import Mesh, bounds
from w2c_sim_robot.scenes.scene import Light, Scene

LAMP = Light(position=(0.0, 0.0, 3.0), direction=(0.0, 0.0, -1.0))


def test_there_are_enough_kinds_each_in_several_colours() -> None:
    assert len(MOVABLE_KINDS) >= 14
    assert all(len(row.colours) >= 3 and set(row.colours) <= set(COLOURS) for row in KINDS.values())


@pytest.mark.parametrize("kind", KINDS)
def test_a_shape_fills_the_size_it_was_asked_for(kind: str) -> None:
    size = random_size(kind, np.random.default_rng(1))
    shape = shape_of(make_object(kind, KINDS[kind].colours[0], (0, 0, 0), size=size, variant=4))

    low, high = bounds(shape)

    assert low[2] == pytest.approx(0.0, abs=2e-3)
    assert high[2] == pytest.approx(size[2], abs=0.06 * size[2] + 3e-3)
    assert (high[:2] - low[:2] <= np.array(size[:2]) * 1.12 + 5e-3).all()
    assert (high[:2] - low[:2] >= 0.92 * min(size[:2])).all()


@pytest.mark.parametrize("kind", KINDS)
def test_normals_have_length_one_and_look_outwards(kind: str) -> None:
    for part in shape_of(make_object(kind, KINDS[kind].colours[0], (0, 0, 0))).parts:
        mesh = part.mesh
        assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(1.0, abs=1e-6)
        assert _agreement(mesh) > 0.98


@pytest.mark.parametrize("kind", MOVABLE_KINDS)
def test_a_thing_stays_where_it_was_put(kind: str) -> None:
    spec = mujoco.MjSpec()
    table = make_object("table", "brown", (0.0, 0.0, 0.0))
    item = make_object(kind, KINDS[kind].colours[0], (0.1, 0.2, table.size[2]), yaw=0.4)
    add_scene(spec, Scene(name="one", objects=(table, item), lights=(LAMP,)))
    model = spec.compile()
    data = mujoco.MjData(model)

    mujoco.mj_step(model, data, 250)

    assert model.body(kind).mass[0] == pytest.approx(item.mass, rel=1e-6)
    assert data.body(kind).xpos == pytest.approx(item.position, abs=4e-3)
    assert data.body(kind).xmat.reshape(3, 3)[2, 2] > np.cos(np.radians(3))


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
