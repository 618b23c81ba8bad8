"""A goal at a point of the world, for `w2c place --point`: nobody saw it on a screen."""

import uuid
from typing import Annotated

import msgspec
import numpy as np

from w2c import topics
from w2c.bus import Bus
from w2c.errors import DeadlineError, RefusedError, UnavailableError
from w2c.messages import EndEffector, PlaceGoal, Task, VetoRequest
from w2c.system import Connection


class PlaceConfig(Connection, frozen=True, kw_only=True):
    """Bring an end effector to a point of the world, or of the picture, without words."""

    end_effector: EndEffector
    """Which one."""
    task: Task = "contact"
    """contact = lean on it, reach = touch it."""
    point: tuple[float, float, float] | None = None
    """On the surface, in the world [m]."""
    pixel: tuple[float, float] | None = None
    """(u, v) in the newest picture."""
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Of the surface at --point."""
    force: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    """Normal force that a hand in contact pushes with, at --point [N]; 0 = as balance finds best.
    At the place where the hand leans already it only changes the force."""
    veto: bool = True
    """Ask the dialogue whether --point is on its veto list, by what the newest picture shows there.
    --no-veto: go there though nobody looks."""
    wait: Annotated[float, msgspec.Meta(ge=0)] = 60.0
    """How long to wait for the end [s]; 0 = return at once."""


def place_point(bus: Bus, config: PlaceConfig) -> tuple[str, str]:
    """Send an end effector to --point, unless that is on the veto list.

    Returns the goal's id, and what could not be looked at; "" = everything was.

    Raises:
        CallError: nobody takes the goal.
        RefusedError: it must not be touched, nobody could look, or the controller says no.
    """
    goal = PlaceGoal(
        goal_id=f"place-{uuid.uuid4().hex[:8]}",
        end_effector=config.end_effector,
        task=config.task,
        point=np.array(config.point),
        normal=np.array(config.normal),
        force=config.force,
    )
    note = _ask_veto(bus, goal) if config.veto else ""
    return bus.call(topics.PLACE, goal).message.goal_id, note


def _ask_veto(bus: Bus, goal: PlaceGoal) -> str:
    """Return what could not be looked at. Raises RefusedError for what must not be touched."""
    try:
        reply = bus.call(topics.VETO, VetoRequest(point=goal.point)).message
    except (UnavailableError, DeadlineError) as error:
        raise RefusedError(
            f"nobody looked for what must not be touched: {error}. Nothing moves. --no-veto goes "
            "there all the same"
        ) from error
    if reply.refusal:
        raise RefusedError(f"{reply.refusal} --no-veto goes there all the same")
    return reply.note
