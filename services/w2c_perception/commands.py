"""`w2c lift U V` and `w2c cloud FILE`: what perception sees in the newest picture."""

from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
import tyro

from w2c import topics
from w2c.bus import Bus
from w2c.bus.zenoh_bus import connect
from w2c.config import parse
from w2c.errors import ConfigError, DeadlineError
from w2c.messages import LiftReply, LiftRequest, PointCloudRequest
from w2c.system import Connection, service_config
from w2c_perception.fitness import Demands, Shape, judge
from w2c_perception.ply import encode_ply

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
        stamp, boot_id = _picture(bus, config.stamp)
        request = LiftRequest(
            u=config.u,
            v=config.v,
            frame_stamp_ns=stamp,
            footprint=config.footprint,
            robot_boot_id=boot_id,
        )
        print(describe(bus.call(topics.LIFT, request).message, config.footprint))
    return 0


class CloudConfig(Connection, frozen=True, kw_only=True):
    """Write what stands in a box of the world as coloured points."""

    file: Annotated[str, tyro.conf.Positional]
    """To write, in the PLY format."""
    stamp: int = -1
    """Of the picture [ns]; -1 = the newest."""
    low: tuple[float, float, float] = (0.0, -1.0, -0.1)
    """Corner of the box with the smallest coordinates: ahead, left, up [m]."""
    high: tuple[float, float, float] = (2.0, 1.0, 2.0)
    """The opposite corner [m]."""
    voxel: Annotated[float, msgspec.Meta(ge=0.001, le=0.5)] = 0.005
    """Points in one cube of this side become one [m]."""


def cloud(arguments: list[str] | None = None) -> int:
    """Write coloured points to a file."""
    config = parse(CloudConfig, arguments or [], program="w2c cloud")
    try:
        request = PointCloudRequest(
            frame_stamp_ns=0, low=config.low, high=config.high, voxel=config.voxel
        )
    except ValueError as error:
        raise ConfigError(f"{error}; choose other --low and --high") from error
    service = service_config(config)
    with connect(service, "operator", [service.router]) as bus:
        stamp, boot_id = _picture(bus, config.stamp)
        request = msgspec.structs.replace(request, frame_stamp_ns=stamp, robot_boot_id=boot_id)
        reply = bus.call(topics.POINT_CLOUD, request).message
    comment = f"robot {service.robot}, picture of {stamp} ns, metres in the world, z up"
    try:
        Path(config.file).write_bytes(encode_ply(reply.points, reply.colours, comment))
    except OSError as error:
        raise ConfigError(f"{config.file} cannot be written: {error}") from error
    print(f"{len(reply.points)} points of the picture of {stamp} ns in {config.file}")
    return 0


def describe(reply: LiftReply, footprint: float) -> str:
    """Return a surface in words and numbers, and whether it can carry a hand of this radius [m]."""
    x, y, z = reply.point
    lines = [
        f"point    {x:.4f} {y:.4f} {z:.4f} m, within {reply.error_bound * 1000:.1f} mm",
        "normal   {:.3f} {:.3f} {:.3f}".format(*reply.normal)
        + f", {np.degrees(reply.slope):.1f} degrees from vertical",
        f"surface  flat within {reply.flatness * 1000:.1f} mm, "
        f"seen {reply.extent * 100:.1f} cm around",
        f"picture  {reply.frame_stamp_ns} ns",
    ]
    shape = Shape(
        reply.normal, reply.error_bound, reply.flatness, reply.extent, reply.edge_distance
    )
    for verdict in judge(shape, Demands(radius=footprint)):
        lines.append(f"{'fit' if verdict.fit else 'NOT FIT':9s}{verdict.reason}")
    return "\n".join(lines + ([f"warning  {reply.warning}"] if reply.warning else []))


def _picture(bus: Bus, stamp_ns: int) -> tuple[int, str]:
    """Return which picture is meant, and of which boot of the robot: the next placed one for -1."""
    if stamp_ns >= 0:
        return stamp_ns, ""
    received = bus.latest(topics.CAMERA_VIEW).wait(_WAIT_FOR_PICTURE_S)
    if received is None:
        raise DeadlineError(
            f"perception placed no picture within {_WAIT_FOR_PICTURE_S:g} s; are robot, camera and "
            "perception running? See: w2c status"
        )
    return received.message.stamp_ns, received.message.robot_boot_id
