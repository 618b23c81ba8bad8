"""`w2c scenes`: scene files, pictures of random scenes with the truth, contact sheets."""

import json
import re
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

SceneName = Literal[
    "scenario_a", "scenario_b", "scenario_c", "scenario_d", "scenario_e", "random"
]  # fmt: skip


class Render(msgspec.Struct, frozen=True, kw_only=True):
    """Render pictures of random scenes through the robot's head camera.

    Each seed gives NAME.png, NAME_identity.png (0 = nothing, n = object with id n, 255 = the
    robot), NAME_depth.png (16 bit, 0.25 mm a unit, 0 = unknown) and, last, NAME.json with the
    truth; docs/reference/scenes.md describes its fields. set.json says what all of them share.
    """

    out: Path
    """Directory, made if it is missing; empty, or of the same set."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """First seed; from 900000 on scenes are for judging only."""
    count: Annotated[int, msgspec.Meta(gt=0)] = 10
    """Number of pictures."""
    width: Annotated[int, msgspec.Meta(ge=16, le=1920)] = 640
    """[px]"""
    height: Annotated[int, msgspec.Meta(ge=16, le=1080)] = 360
    """[px]"""
    picture: Literal["png", "jpg"] = "png"
    """Of the colours; jpg is five times smaller and loses a little."""
    depth: bool = True
    """Write NAME_depth.png, too."""
    resume: bool = False
    """Keep pictures that are there, and make the others."""
    jobs: Annotated[int, msgspec.Meta(ge=1, le=64)] = 1
    """Processes that render at once; each takes 0.4 GB. The pictures are the same."""
    paper_share: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.2
    """Of scenes that are arranged like one of the paper's, with its things."""
    twins_share: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """Of the others: nothing but twins, of one kind and colour, but other materials or sizes."""
    json: Path | None = None
    """Write the list of truth files there."""


class Make(msgspec.Struct, frozen=True, kw_only=True):
    """Write a scene file."""

    out: Path
    """The file."""
    kind: SceneName = "scenario_a"
    """Which one."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of the layout; of scenario_a the grain and print only."""
    book: tuple[float, float] = (0.50, -0.25)
    """Where the book of scenario_a lies [m]."""
    cup: tuple[float, float] = (1.08, 0.16)
    """Where the cup of scenario_a stands [m]."""
    table_height: Annotated[float, msgspec.Meta(ge=0.4, le=1.1)] = 0.80
    """Of scenario_a [m]."""


class Sheet(msgspec.Struct, frozen=True, kw_only=True):
    """Draw contact sheets: kinds.jpg, scenes.jpg, random.jpg."""

    out: Path
    """Directory, made if it is missing."""
    of: Literal["all", "kinds", "scenes", "random"] = "all"
    """Which of them; `kinds` takes minutes without a graphics card."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of the layouts, and first one of the random scenes."""
    count: Annotated[int, msgspec.Meta(gt=0, le=60)] = 12
    """Of the random scenes."""


def _render(options: Render) -> None:
    from w2c_sim_robot.camera.gl import choose_backend

    choose_backend()
    with needs_extra("sim-robot"):
        from w2c_sim_robot.scenes.picture_set import SetDescription
        from w2c_sim_robot.scenes.render import render
    start = time.monotonic()
    written = []
    description = SetDescription(
        width=options.width,
        height=options.height,
        picture=options.picture,
        depth=options.depth,
        paper_share=options.paper_share,
        twins_share=options.twins_share,
    )
    for path in render(
        options.out,
        options.seed,
        options.count,
        description,
        resume=options.resume,
        jobs=options.jobs,
    ):
        written.append(str(path))
        if len(written) % 100 == 0:
            rate = len(written) / (time.monotonic() - start)
            print(f"{len(written)} of {options.count} pictures, {rate:.1f} a second", flush=True)
    print(f"{len(written)} pictures in {options.out}")
    if options.json is not None:
        options.json.write_text(json.dumps(written, indent=1) + "\n")


def _make(options: Make) -> None:
    with needs_extra("sim-robot"):
        from w2c_sim_robot.scenes.named import named_scene
        from w2c_sim_robot.scenes.scenario_a import scenario_a
        from w2c_sim_robot.scenes.scene import save

    if options.kind == "scenario_a":
        scene = scenario_a(
            book_xy=options.book,
            cup_xy=options.cup,
            table_height=options.table_height,
            seed=options.seed,
        )
    else:
        scene = named_scene(options.kind, options.seed)
    save(scene, options.out)
    print(f"{options.out}: {', '.join(item.name for item in scene.objects)}")


def _sheet(options: Sheet) -> None:
    from w2c_sim_robot.camera.gl import choose_backend

    choose_backend()
    with needs_extra("sim-robot"):
        from w2c_sim_robot.scenes import sheet
        from w2c_sim_robot.scenes.named import SCENES, named_scene
    sheets: dict[str, Callable[[], sheet.Rgb]] = {
        "kinds": sheet.kinds_sheet,
        "scenes": lambda: sheet.scenes_sheet(
            [named_scene(name, options.seed) for name in SCENES if name != "random"]
        ),
        "random": lambda: sheet.random_sheet(options.seed, options.count),
    }
    for name, draw in sheets.items():
        if options.of in ("all", name):
            path = options.out / f"{name}.jpg"
            sheet.save_picture(draw(), path)
            print(path, flush=True)


def _flagged(error: msgspec.ValidationError, options: Render | Make | Sheet) -> ConfigError:
    """Return the complaint with flag and value instead of the field."""
    text, _, path = str(error).partition(" - at `$.")
    field = re.sub(r"[`\[].*", "", path)
    value = getattr(options, field, "")
    return ConfigError(f"--{field.replace('_', '-')} {value}: {text.lower()}")


def main(arguments: list[str] | None = None) -> int:
    """Run `w2c scenes render|make|sheet`. Exit status: 0 done, 1 failed, 2 usage."""
    argv = sys.argv[1:] if arguments is None else arguments
    commands: dict[str, Callable[..., Render | Make | Sheet]] = {
        "render": Render,
        "make": Make,
        "sheet": Sheet,
    }
    chosen = tyro.extras.subcommand_cli_from_dict(commands, prog="w2c scenes", args=argv)
    try:
        checked = msgspec.convert(msgspec.structs.asdict(chosen), type(chosen))
        if isinstance(checked, Render):
            _render(checked)
        elif isinstance(checked, Make):
            _make(checked)
        else:
            _sheet(checked)
    except msgspec.ValidationError as error:
        return fail(_flagged(error, chosen), "w2c scenes")
    except W2CError as error:
        return fail(error, "w2c scenes")
    except OSError as error:
        return fail(W2CError(f"{error}"), "w2c scenes")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
