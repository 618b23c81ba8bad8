"""Depth is unpacked once for many questions, and only a few pictures are kept unpacked."""

import numpy as np
import pytest

from w2c.depth import encode_depth
from w2c.errors import MessageError
from w2c.messages import CameraFrame
from w2c_perception.buffer import View
from w2c_perception.depths import DepthMemory
from w2c_perception.pose import CameraPose
from w2c_perception.window import DepthPicture

POSE = CameraPose(np.eye(4), np.zeros((0, 2, 3)), np.zeros((1, 6)))


class CountedView(View):
    """A view that counts how often it is unpacked."""

    def __init__(self, metres: float, depth: bytes | None = None) -> None:
        plane = encode_depth(np.full((4, 8), metres, np.float32))
        frame = CameraFrame(
            stamp_ns=1,
            frame="camera",
            width=8,
            height=4,
            intrinsics=(10.0, 10.0, 4.0, 2.0),
            jpeg=b"",
            depth=plane if depth is None else depth,
        )
        super().__init__(frame, POSE, np.zeros(1))
        self.unpacked = 0

    def unpack_depth(self) -> DepthPicture:
        self.unpacked += 1
        return super().unpack_depth()


def test_a_picture_is_unpacked_for_the_first_question_only() -> None:
    view, memory = CountedView(1.5), DepthMemory(2)

    depths = [memory.of(view) for _ in range(5)]

    assert view.unpacked == 1
    assert depths[-1][:] == pytest.approx(np.full((4, 8), 1.5), abs=2e-4)


def test_two_pictures_of_one_stamp_are_not_mixed() -> None:
    """A robot that started anew counts time from zero again."""
    memory = DepthMemory(2)
    before, after = CountedView(1.0), CountedView(2.0)

    assert memory.of(before)[0, 0] == pytest.approx(1.0, abs=2e-4)
    assert memory.of(after)[0, 0] == pytest.approx(2.0, abs=2e-4)


def test_those_that_were_asked_for_last_are_kept() -> None:
    memory = DepthMemory(2)
    first, second, third = CountedView(1.0), CountedView(1.0), CountedView(1.0)
    for view in (first, second, first, third, first, second):
        memory.of(view)

    assert (first.unpacked, second.unpacked, third.unpacked) == (1, 2, 1)


def test_what_cannot_be_unpacked_is_not_remembered_and_clear_forgets() -> None:
    memory = DepthMemory(2)
    broken, whole = CountedView(1.0, b"no depth"), CountedView(1.0)
    for _ in range(2):
        with pytest.raises(MessageError):
            memory.of(broken)
    memory.of(whole)
    memory.clear()
    memory.of(whole)

    assert (broken.unpacked, whole.unpacked) == (2, 2)
