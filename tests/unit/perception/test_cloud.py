"""Coloured points: where they are, their colours, how many; and the PLY file of them."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.surfaces import CAMERA, HEIGHT, TABLE, WIDTH, WORLD_FROM_CAMERA, quantised
from w2c.errors import ConfigError, MessageError, RefusedError
from w2c_perception.cloud import Box, Cloud, decode_colours, point_cloud
from w2c_perception.commands import cloud as cloud_command
from w2c_perception.ply import encode_ply

BOX = Box((0.4, -0.3, 0.5), (1.2, 0.3, 1.0))
RED = np.tile(np.array([200, 10, 20], np.uint8), (HEIGHT, WIDTH, 1))


def cloud(box: Box = BOX, voxel: float = 0.02, most: int = 100_000) -> Cloud:
    return point_cloud(
        quantised(TABLE), RED, CAMERA, WORLD_FROM_CAMERA, box, voxel=voxel, most=most
    )


def test_points_are_on_the_table_and_in_the_box() -> None:
    points = cloud().points

    assert points[:, 2] == pytest.approx(np.full(len(points), 0.8), abs=1e-3)
    assert (points.min(axis=0)[:2] >= BOX.low[:2]).all()
    assert (points.max(axis=0)[:2] < BOX.high[:2]).all()
    assert points.dtype == np.float32


def test_one_point_a_voxel() -> None:
    found = cloud(voxel=0.05)

    keys = np.floor((found.points - np.array(BOX.low)) / 0.05).astype(int)
    assert len(np.unique(keys, axis=0)) == len(found.points)
    # A table of 80 x 60 cm in cells of 5 cm, of which the camera sees a part.
    assert 100 <= len(found.points) <= 16 * 12 * 1.2


def test_colours_come_along_and_are_means() -> None:
    half = RED.copy()
    half[:, WIDTH // 2 :] = (0, 100, 0)
    found = point_cloud(
        quantised(TABLE), half, CAMERA, WORLD_FROM_CAMERA, BOX, voxel=0.02, most=10_000
    )

    left = found.points[:, 1] > 0.03
    right = found.points[:, 1] < -0.03
    assert (found.colours[left] == [200, 10, 20]).all()
    assert (found.colours[right] == [0, 100, 0]).all()


def test_a_box_without_anything_is_empty() -> None:
    empty = cloud(Box((5.0, 5.0, 5.0), (6.0, 6.0, 6.0)))

    assert empty.points.shape == (0, 3)
    nothing = point_cloud(
        np.zeros((HEIGHT, WIDTH), np.float32),
        RED,
        CAMERA,
        WORLD_FROM_CAMERA,
        BOX,
        voxel=0.1,
        most=1,
    )
    assert nothing.colours.shape == (0, 3)


def test_too_many_points_are_refused_with_a_voxel_that_fits() -> None:
    with pytest.raises(RefusedError, match=r"limit 300: choose a voxel of 0\.0\d\d m") as caught:
        cloud(voxel=0.01, most=300)

    wider = float(str(caught.value).split("voxel of ")[1].split(" m")[0])
    assert len(cloud(voxel=wider, most=300).points) <= 300


def test_a_jpeg_is_decoded_and_another_size_refused() -> None:
    jpeg = cv2.imencode(".jpg", np.full((4, 8, 3), (0, 0, 255), np.uint8))[1].tobytes()

    assert decode_colours(jpeg, 8, 4)[0, 0, 0] > 240  # red comes first
    with pytest.raises(MessageError, match="8x4 px, the frame says 4x4"):
        decode_colours(jpeg, 4, 4)
    with pytest.raises(MessageError, match="no JPEG"):
        decode_colours(b"", 4, 4)
    with pytest.raises(MessageError, match="no JPEG"):
        decode_colours(b"rubbish", 4, 4)


def read_ply(encoded: bytes) -> tuple[list[str], np.ndarray]:
    """Return header lines and vertices of a PLY file as any viewer reads it."""
    header, _, body = encoded.partition(b"end_header\n")
    kind = np.dtype([*((name, "<f4") for name in "xyz"), ("r", "u1"), ("g", "u1"), ("b", "u1")])
    return header.decode("ascii").splitlines(), np.frombuffer(body, kind)


@settings(max_examples=20)
@given(count=st.integers(0, 50), comment=st.text(max_size=40), seed=st.integers(0, 1000))
def test_a_ply_file_holds_what_was_written(count: int, comment: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(0, 10, (count, 3)).astype(np.float32)
    colours = rng.integers(0, 256, (count, 3), dtype=np.uint8)

    header, vertices = read_ply(encode_ply(points, colours, comment))

    assert header[:2] == ["ply", "format binary_little_endian 1.0"]
    assert f"element vertex {count}" in header
    assert [line for line in header if line.startswith("property")] == [
        *(f"property float {name}" for name in "xyz"),
        *(f"property uchar {name}" for name in ("red", "green", "blue")),
    ]
    assert np.stack([vertices["x"], vertices["y"], vertices["z"]], 1).tolist() == points.tolist()
    assert np.stack([vertices["r"], vertices["g"], vertices["b"]], 1).tolist() == colours.tolist()


def test_arrays_that_do_not_fit_are_no_ply() -> None:
    with pytest.raises(ValueError, match="expected"):
        encode_ply(np.zeros((2, 3), np.float32), np.zeros((1, 3), np.uint8))


@pytest.mark.parametrize(
    "flags", [["--low", "2", "0", "0"], ["--voxel", "0"], ["--high", "nan", "1", "1"]]
)
def test_a_cloud_of_no_box_is_a_usage_error_before_anything_is_asked(flags: list[str]) -> None:
    with pytest.raises(ConfigError):
        cloud_command(["out.ply", *flags])
