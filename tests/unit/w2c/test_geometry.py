"""Poses and pixels: every transform has its round trip."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from w2c import geometry
from w2c.errors import GeometryError
from w2c.geometry import Intrinsics

NUMBERS = st.floats(-10, 10, allow_nan=False)
VECTORS = hnp.arrays(np.float64, 3, elements=NUMBERS)
QUATERNIONS = hnp.arrays(np.float64, 4, elements=st.floats(-1, 1))
CAMERA = Intrinsics(900.0, 910.0, 640.0, 360.0)


def rotation(quaternion: geometry.Vector) -> geometry.Matrix:
    assume(np.linalg.norm(quaternion) > 0.1)
    return geometry.rotation_from_quaternion(quaternion / np.linalg.norm(quaternion))


@given(QUATERNIONS)
def test_quaternion_and_rotation_are_inverse(quaternion: geometry.Vector) -> None:
    matrix = rotation(quaternion)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-12)
    again = geometry.quaternion_from_rotation(matrix)
    np.testing.assert_allclose(geometry.rotation_from_quaternion(again), matrix, atol=1e-9)
    assert again[3] >= 0


@given(QUATERNIONS, VECTORS, VECTORS)
def test_a_transform_and_its_inverse_cancel(
    quaternion: geometry.Vector, translation: geometry.Vector, point: geometry.Vector
) -> None:
    world_from_camera = geometry.transform(rotation(quaternion), translation)
    there = geometry.apply(world_from_camera, point)
    back = geometry.apply(geometry.inverse(world_from_camera), there)
    np.testing.assert_allclose(back, point, atol=1e-9)


@given(st.floats(0, 1280), st.floats(0, 720), st.floats(0.1, 10))
def test_pixel_to_point_and_back(u: float, v: float, depth: float) -> None:
    point = CAMERA.point_from_pixel(u, v, depth)
    np.testing.assert_allclose(CAMERA.pixel_from_point(point), (u, v), atol=1e-9)


def test_directions_of_the_image() -> None:
    """Right in the image is +x of the camera, down is +y."""
    u, v = CAMERA.pixel_from_point(np.array([0.1, 0.2, 1.0]))
    assert u > CAMERA.cx
    assert v > CAMERA.cy


def test_a_point_behind_the_camera_has_no_pixel() -> None:
    with pytest.raises(GeometryError, match="behind"):
        CAMERA.pixel_from_point(np.array([0.0, 0.0, -1.0]))


def test_the_field_of_view_reaches_the_edge_of_the_picture() -> None:
    camera = geometry.intrinsics_from_fov(1280, 720, np.deg2rad(42.0))
    edge = camera.point_from_pixel(640.0, 0.0, 1.0)
    assert np.rad2deg(np.arctan2(-edge[1], edge[2])) == pytest.approx(21.0)


@given(VECTORS)
def test_a_contact_frame_is_right_handed_and_its_z_is_the_normal(normal: geometry.Vector) -> None:
    assume(np.linalg.norm(normal) > 1e-3)
    frame = geometry.frame_from_normal(normal)
    np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-9)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    np.testing.assert_allclose(frame[:, 2], normal / np.linalg.norm(normal), atol=1e-9)


def test_a_table_gives_the_identity() -> None:
    np.testing.assert_allclose(geometry.frame_from_normal((0, 0, 2.0)), np.eye(3))


def test_a_vector_without_direction_is_refused() -> None:
    with pytest.raises(GeometryError, match="no direction"):
        geometry.unit([0.0, 0.0, 0.0])


def test_a_quaternion_that_is_none_is_refused() -> None:
    with pytest.raises(GeometryError, match="length 2"):
        geometry.rotation_from_quaternion([0.0, 0.0, 0.0, 2.0])


def test_the_world_is_midway_between_the_soles() -> None:
    left = geometry.transform(np.eye(3), [0.1, 0.1, -1.0])
    right = geometry.transform(np.eye(3), [0.1, -0.1, -1.0])
    world_from_base = geometry.inverse(geometry.base_from_midfeet(left, right))
    np.testing.assert_allclose(geometry.apply(world_from_base, [0.0, 0.0, 0.0]), [-0.1, 0.0, 1.0])
