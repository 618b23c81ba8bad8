"""`w2c scenes`: make scene files, and pictures of random scenes with the truth about them."""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import tyro

from w2c.config import fail
from w2c.errors import ConfigError, W2CError
from w2c.extras import needs_extra


class Render(msgspec.Struct, frozen=True, kw_only=True):
    """Render pictures of random scenes through the robot's head camera.

    Each seed gives NAME.jpg, NAME_identity.png (0 = nothing, n = object with id n, 255 = the
    robot) and NAME.json: image, identity, width, height, seed, intrinsics (fx, fy, cx, cy),
    world_from_camera, and for each object id, name, kind, colour, material, names, phrases (all
    that fit it; another object may fit too), held_out (kind and colour are never seen together
    below seed 900000), box (left, top, right, bottom; null where it is not visible),
    visible_pixels, position, orientation (xyzw), size, support.
    """

    out: Path
    """Directory, made if it is missing."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """First seed; from 900000 on scenes are for judging only."""
    count: Annotated[int, msgspec.Meta(gt=0)] = 10
    """Number of pictures."""
    width: Annotated[int, msgspec.Meta(ge=16, le=1920)] = 640
    """[px]"""
    height: Annotated[int, msgspec.Meta(ge=16, le=1080)] = 360
    """[px]"""
    depth: bool = False
    """Write NAME_depth.png too: 16 bit, 0.25 mm a unit, 0 = unknown."""
    resume: bool = False
    """Keep pictures that are there."""
    paper_share: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.2
    """Of scenes with book and mug where the paper's scene (a) has them."""
    json: Path | None = None
    """Write the list of truth files there."""


class Make(msgspec.Struct, frozen=True, kw_only=True):
    """Write a scene file."""

    out: Path
    """The file."""
    kind: Literal["scenario_a", "random"] = "scenario_a"
    """Which one."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of the random scene, or of the grain and print of scenario_a."""
    book: tuple[float, float] = (0.50, -0.25)
    """Where the book of scenario_a lies [m]."""
    cup: tuple[float, float] = (1.08, 0.16)
    """Where the cup of scenario_a stands [m]."""
    table_height: Annotated[float, msgspec.Meta(ge=0.4, le=1.1)] = 0.80
    """Of scenario_a [m]."""


def _render(options: Render) -> None:
    from w2c_sim_robot.camera.gl import choose_backend

    choose_backend()
    with needs_extra("sim-robot"):
        from w2c_sim_robot.scenes.render import render
    start = time.monotonic()
    written = []
    size = (options.width, options.height)
    for path in render(
        options.out,
        options.seed,
        options.count,
        size,
        depth=options.depth,
        resume=options.resume,
        paper_share=options.paper_share,
    ):
        written.append(str(path))
        if len(written) % 100 == 0:
            rate = len(written) / (time.monotonic() - start)
            print(f"{len(written)} of {options.count} pictures, {rate:.1f} a second", flush=True)
    print(f"{len(written)} pictures in {options.out}")
    if options.json is not None:
        options.json.write_text(json.dumps(written, indent=1) + "\n")


def _make(options: Make) -> None:
    from w2c_sim_robot.scenes.random_scene import random_scene
    from w2c_sim_robot.scenes.scenario_a import scenario_a
    from w2c_sim_robot.scenes.scene import save

    if options.kind == "random":
        scene = random_scene(options.seed)
    else:
        scene = scenario_a(
            book_xy=options.book,
            cup_xy=options.cup,
            table_height=options.table_height,
            seed=options.seed,
        )
    save(scene, options.out)
    print(f"{options.out}: {', '.join(item.name for item in scene.objects)}")


def main(arguments: list[str] | None = None) -> int:
    """Run `w2c scenes render|make`. Returns the exit status: 0 done, 1 failed, 2 usage."""
    argv = sys.argv[1:] if arguments is None else arguments
    commands: dict[str, Callable[..., Render | Make]] = {"render": Render, "make": Make}
    chosen = tyro.extras.subcommand_cli_from_dict(commands, prog="w2c scenes", args=argv)
    try:
        checked = msgspec.convert(msgspec.structs.asdict(chosen), type(chosen))
        if isinstance(checked, Render):
            _render(checked)
        else:
            _make(checked)
    except msgspec.ValidationError as error:
        return fail(ConfigError(f"{error}"), "w2c scenes")
    except W2CError as error:
        return fail(error, "w2c scenes")
    except OSError as error:
        return fail(ConfigError(f"{error}"), "w2c scenes")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
