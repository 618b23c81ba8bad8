"""`w2c lift U V`: what perception sees behind a pixel of the newest picture."""

from typing import Annotated

import msgspec
import numpy as np
import tyro

from w2c import topics
from w2c.bus import Bus
from w2c.bus.zenoh_bus import connect
from w2c.config import parse
from w2c.errors import DeadlineError
from w2c.messages import LiftReply, LiftRequest
from w2c.system import Connection, service_config

_WAIT_FOR_PICTURE_S = 5.0


class LiftConfig(Connection, frozen=True, kw_only=True):
    """Show the point and the surface behind a pixel."""

    u: Annotated[float, tyro.conf.Positional]
    """To the right from the left border [px]."""
    v: Annotated[float, tyro.conf.Positional]
    """Down from the upper border [px]."""
    stamp: int = -1
    """Of the picture [ns]; -1 = the newest."""
    footprint: Annotated[float, msgspec.Meta(gt=0.0, le=0.5)] = 0.03
    """Radius of what will touch the surface [m]."""


def lift(arguments: list[str] | None = None) -> int:
    """Print what is behind a pixel. A refusal is an error with its reason."""
    config = parse(LiftConfig, arguments or [], program="w2c lift")
    service = service_config(config)
    with connect(service, "operator", [service.router]) as bus:
        stamp = config.stamp if config.stamp >= 0 else _newest_stamp(bus)
        request = LiftRequest(
            u=config.u, v=config.v, frame_stamp_ns=stamp, footprint=config.footprint
        )
        print(describe(bus.call(topics.LIFT, request).message))
    return 0


def describe(reply: LiftReply) -> str:
    """Return a surface in words and numbers."""
    x, y, z = reply.point
    lines = [
        f"point    {x:.4f} {y:.4f} {z:.4f} m, within {reply.error_bound * 1000:.1f} mm",
        "normal   {:.3f} {:.3f} {:.3f}".format(*reply.normal)
        + f", {np.degrees(reply.slope):.1f} degrees from vertical",
        f"surface  flat within {reply.flatness * 1000:.1f} mm, "
        f"seen {reply.extent * 100:.1f} cm around",
        f"picture  {reply.frame_stamp_ns} ns",
    ]
    return "\n".join(lines + ([f"warning  {reply.warning}"] if reply.warning else []))


def _newest_stamp(bus: Bus) -> int:
    """Return the stamp of the next picture that perception has placed."""
    received = bus.latest(topics.CAMERA_VIEW).wait(_WAIT_FOR_PICTURE_S)
    if received is None:
        raise DeadlineError(
            f"perception placed no picture within {_WAIT_FOR_PICTURE_S:g} s; are robot, camera and "
            "perception running? See: w2c status"
        )
    return received.message.stamp_ns
