"""What Foxglove and Rerun show is what was recorded, beside the bytes of the bus."""

import itertools
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from mcap.reader import make_reader

from support.disk import file_size_limit
from support.recordings import raw_mark
from support.robots import URDF
from support.robots import robot_session as session
from support.sessions import SECOND, Session, frame, status
from w2c import messages as m
from w2c import topics
from w2c.bus import RawReceived
from w2c.depth import encode_depth
from w2c.errors import GeometryError, RecordingError
from w2c.geometry import quaternion_from_rotation, rotation_from_quaternion
from w2c_recorder.commands import recording
from w2c_recorder.foxglove.cloud import cloud_of
from w2c_recorder.foxglove.mirror import Mirror
from w2c_recorder.foxglove.tree import LinkTree, quaternions
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.reading import Recording


def exported(told: Session, directory: Path) -> dict[str, list[Any]]:
    """Export a session for Foxglove; return topic -> messages, read by the schemas in it."""
    out = directory / "shown.mcap"
    source = told.write(directory / "session.mcap")
    assert recording(["export", str(source), "--to", "foxglove", "--out", str(out)]) == 0
    found: dict[str, list[Any]] = {}
    with out.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            if channel.message_encoding != "protobuf" or schema is None:
                continue
            pool = DescriptorPool()
            for file in FileDescriptorSet.FromString(schema.data).file:
                pool.Add(file)
            kind = GetMessageClass(pool.FindMessageTypeByName(schema.name))
            found.setdefault(channel.topic, []).append(kind.FromString(message.data))
    return found


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Any]]:
    return exported(session(), tmp_path_factory.mktemp("foxglove"))


def test_pictures_come_with_their_camera(shown: dict[str, list[Any]]) -> None:
    first, second = shown["foxglove/test/camera/image"]

    assert first.DESCRIPTOR.full_name == "foxglove.CompressedImage"
    assert (first.frame_id, first.format, first.data[:2]) == ("camera", "jpeg", b"\xff\xd8")
    assert first.timestamp.ToNanoseconds() < second.timestamp.ToNanoseconds()
    calibration = shown["foxglove/test/camera/calibration"][0]
    assert (calibration.K[0], calibration.K[2], calibration.width) == (50.0, 32.0, 64)


def test_joints_and_logs_have_their_names_and_numbers(shown: dict[str, list[Any]]) -> None:
    states = shown["foxglove/test/joints"]
    assert len(states) == 1  # ten a second; the session moves for a tenth
    assert [(joint.name, joint.position) for joint in states[0].joints] == [
        ("slide", 0.0), ("turn", -0.1),
    ]  # fmt: skip
    (line,) = shown["foxglove/test/log"]
    assert (line.message, line.name, line.level) == ("slow", "llm: a", 3)


def test_links_form_a_tree_that_hangs_on_the_world(shown: dict[str, list[Any]]) -> None:
    transforms = {one.child_frame_id: one for one in shown["foxglove/test/tf"][0].transforms}

    parents = {name: one.parent_frame_id for name, one in transforms.items()}
    assert parents == {"base": "world", "left": "base", "right": "base", "sole": "left"}
    assert transforms["sole"].translation.z == pytest.approx(-0.9)
    # The world lies between the soles, here 0.9 m below the one and level with the other.
    assert transforms["base"].translation.z == pytest.approx(0.45)
    (lines,) = shown["foxglove/test/robot"][0].entities[0].lines
    assert len(lines.points) == 2 * 3


def test_the_target_is_a_mark_in_the_picture_and_in_the_world(shown: dict[str, list[Any]]) -> None:
    (marks,) = shown["foxglove/test/camera/target"]
    assert (marks.circles[0].position.x, marks.circles[0].position.y) == (10.0, 20.0)
    assert len(marks.points[0].points) == 4
    assert marks.texts[0].text == "mug 0.50"
    (scene,) = shown["foxglove/test/target"]
    assert scene.entities[0].spheres[0].pose.position.z == pytest.approx(0.8)


def test_the_bytes_of_the_bus_are_untouched(tmp_path: Path) -> None:
    told = session()
    exported(told, tmp_path)
    before, after = Recording(tmp_path / "session.mcap"), Recording(tmp_path / "shown.mcap")

    assert [(r.key, r.payload, r.log_time_ns) for r in before.messages(decode=False)] == [
        (r.key, r.payload, r.log_time_ns) for r in after.messages(decode=False)
    ]
    assert after.metadata["session"] == before.metadata["session"]
    assert after.elsewhere["foxglove/test/joints"] == 1
    assert before.elsewhere == {}


def test_a_full_disk_leaves_no_part_of_a_file(tmp_path: Path) -> None:
    exported(session(), tmp_path)
    before = set(tmp_path.iterdir())
    arguments = ["export", str(tmp_path / "session.mcap"), "--to", "foxglove"]

    with file_size_limit(2000), pytest.raises(RecordingError, match="cannot be written"):
        recording([*arguments, "--out", str(tmp_path / "again.mcap")])

    assert set(tmp_path.iterdir()) == before


def test_info_tells_repeats_from_recorded_channels(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    exported(session(), tmp_path)
    capsys.readouterr()
    recording(["info", str(tmp_path / "shown.mcap")])

    printed = capsys.readouterr().out
    assert "foxglove/test/tf  1 in another encoding" in printed
    assert "MALFORMED" not in printed


def test_the_base_follows_the_soles_of_the_controller() -> None:
    told = session()
    soles = np.tile([0.3, 0.2, 0.0, 0.0, 0.0, 0.0, 1.0], (2, 1))
    standing = m.ControllerStatus(**{
        name: getattr(status("hold"), name) for name in m.ControllerStatus.__struct_fields__
    } | {"soles": soles})  # fmt: skip
    told.add(0.3, topics.CONTROLLER_STATUS, standing)
    mirror = Mirror()
    raw = sorted(told.raw, key=lambda one: one.received_ns)
    found = itertools.chain.from_iterable(
        mirror.shown(r.key, r.payload, r.received_ns) for r in raw
    )

    (tf, *_) = [one.message for one in found if one.topic == "tf"]
    base = tf.transforms[0]
    assert (base.translation.x, base.translation.y) == pytest.approx((0.3, 0.1))
    assert base.translation.z == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("urdf", "problem"),
    [
        ("no robot", "no URDF"),
        ("<!DOCTYPE x [<!ENTITY a 'b'>]><robot/>", "declares entities"),
        (URDF.replace('parent link="left"', 'parent link="sole"'), "no tree"),
        (URDF.replace("0 0.1 0", "0 high 0"), "no URDF"),
    ],
    ids=["words", "entities", "a ring", "no numbers"],
)
def test_a_description_that_is_none_leaves_the_rest(
    tmp_path: Path, urdf: str, problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(GeometryError, match=problem):
        LinkTree(urdf, ["slide", "turn"])
    found = exported(session(urdf), tmp_path)

    assert "foxglove/test/tf" not in found
    assert found["foxglove/test/joints"] and found["foxglove/test/camera/image"]
    assert problem in capsys.readouterr().out


def test_angles_move_links_along_and_about_their_axes() -> None:
    tree = LinkTree(URDF, ["slide", "turn"])
    links = tree.root_from_links(tree.parent_from_child(np.array([0.25, np.pi / 2])))

    assert links["sole"][:3, 3] == pytest.approx((0.0, 0.1, 0.25 - 0.9))
    # A quarter turn by the origin and one by the joint: x of the child points to -x of the base.
    assert links["right"][:3, 0] == pytest.approx((-1.0, 0.0, 0.0))


def test_quaternions_of_many_are_those_of_each() -> None:
    random = np.random.default_rng(0)
    wanted = random.normal(size=(50, 4))
    wanted[:4] = np.eye(4)
    wanted /= np.linalg.norm(wanted, axis=1, keepdims=True)
    rotations = np.array([rotation_from_quaternion(one) for one in wanted])

    expected = [quaternion_from_rotation(rotation) for rotation in rotations]

    assert quaternions(rotations) == pytest.approx(np.array(expected), abs=1e-12)


class BrokenMirror(Mirror):
    """Fails at the first message."""

    def shown(self, key: str, payload: bytes, time_ns: int) -> Any:
        """Fail."""
        raise ValueError("a fault")


def test_a_fault_of_the_mirror_ends_the_mirror_and_not_the_recording(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = McapFile(tmp_path / "a.mcap", {}, mirror=BrokenMirror())
    for number in range(3):
        file.write(raw_mark("x", number), number * SECOND + 1)
    file.close()

    assert len(list(Recording(tmp_path / "a.mcap").messages())) == 3
    assert [record.message for record in caplog.records] == [
        "nothing is repeated for Foxglove any more"
    ]


def test_what_does_not_decode_is_not_shown() -> None:
    mirror = Mirror()
    keys = (topics.CAMERA_FRAME.key("test"), topics.TRACE.key("test", "llm"), "w2c/v9/x", "")
    for key in keys:
        for payload in (b"", b"\xc1", b"\x80", b"describe" * 9, RawReceived.__doc__ or b""):
            data = payload if isinstance(payload, bytes) else payload.encode()
            assert list(mirror.shown(key, data, 1)) == []


def test_depth_becomes_points_where_it_is_known() -> None:
    depth = np.zeros((48, 64), np.float32)
    depth[18, 30] = 2.0
    seen = msgspec.structs.replace(frame(1), depth=encode_depth(depth))

    cloud = cloud_of(seen, 1)

    assert cloud is not None
    assert np.frombuffer(cloud.data, "<f4") == pytest.approx(
        [2 * (30.5 - 32) / 50, 2 * (18.5 - 24) / 50, 2.0], abs=1e-3
    )
    assert cloud_of(frame(1), 1) is None


def test_depth_that_is_none_leaves_the_picture(tmp_path: Path) -> None:
    told = session()
    told.add(0.6, topics.CAMERA_FRAME, msgspec.structs.replace(frame(7), depth=b"no depth"))

    found = exported(told, tmp_path)

    assert len(found["foxglove/test/camera/image"]) == 3
    assert "foxglove/test/camera/cloud" not in found
