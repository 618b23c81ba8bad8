"""A point of the world is looked at in the newest picture before anything goes there."""

import numpy as np
import pytest

from support.conversing import BOOK, World
from w2c.errors import UnavailableError
from w2c.messages import VetoReply, VetoRequest
from w2c_dialogue.advice.guard import Guard
from w2c_dialogue.advice.points import PointVeto
from w2c_dialogue.advice.veto import UncheckedVeto
from w2c_dialogue.frames import FrameStore

ON_THE_BOOK = (-0.14, 0.0, 1.0)
"""Pixel (500, 360) of a camera at the origin that looks along z"""


def ask(
    world: World, point: tuple[float, float, float], unchecked: UncheckedVeto = "refuse"
) -> VetoReply:
    guard = Guard(world.watch, ("person",), share=0.3, margin=0.05, unchecked=unchecked)
    request = VetoRequest(point=np.array(point))
    return PointVeto(guard, world.frames).answer(request, None)  # type: ignore[arg-type]


@pytest.fixture
def world() -> World:
    world = World()
    world.grounding.things["person"] = BOOK
    world.add_view(100)
    return world


def test_a_point_on_a_person_is_refused_with_the_reason(world: World) -> None:
    reply = ask(world, ON_THE_BOOK)
    assert "'person'" in reply.refusal
    assert "limit" in reply.refusal


def test_a_point_beside_is_not_by_the_margin_in_metres(world: World) -> None:
    """The person ends at pixel 600: 5 cm left of the axis at a metre, 10 cm at two."""
    assert ask(world, (0.0, 0.0, 1.0)).refusal != ""
    assert ask(world, (0.02, 0.0, 1.0)).refusal == ""
    assert ask(world, (0.0, 0.0, 2.0)).refusal == ""


def test_a_point_outside_of_the_picture_is_not_looked_at_and_that_is_said(world: World) -> None:
    for point in ((5.0, 0.0, 1.0), (0.0, 0.0, -1.0)):
        reply = ask(world, point)
        assert reply.refusal == ""
        assert "not in the picture" in reply.note


def test_where_nobody_can_look_it_is_refused_or_said(world: World) -> None:
    world.grounding.error = UnavailableError("grounding is gone")
    assert "grounding is gone" in ask(world, ON_THE_BOOK).refusal
    allowed = ask(world, ON_THE_BOOK, "allow")
    assert allowed.refusal == ""
    assert "grounding is gone" in allowed.note


def test_without_a_picture_or_a_pose_nobody_can_look(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("w2c_dialogue.advice.points.VIEW_WAIT_S", 0.0)
    world.frames = FrameStore()
    assert "no picture" in ask(world, ON_THE_BOOK).refusal
    world.add_frame(100)
    assert "where the camera is" in ask(world, ON_THE_BOOK).refusal
    assert "where the camera is" in ask(world, ON_THE_BOOK, "allow").note


def test_without_a_list_nothing_is_looked_at() -> None:
    world = World()
    guard = Guard(world.watch, (), share=0.3, margin=0.05, unchecked="refuse")
    world.frames = FrameStore()
    request = VetoRequest(point=np.array(ON_THE_BOOK))
    reply = PointVeto(guard, world.frames).answer(request, None)  # type: ignore[arg-type]
    assert reply.refusal == ""
    assert world.grounding.watched == []
