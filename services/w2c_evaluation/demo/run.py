"""One run of the scenario: layout, private system, operator's lines, pictures, summary."""

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from w2c import topics
from w2c.bus.zenoh_bus import connect
from w2c.config import ServiceConfig
from w2c.errors import W2CError
from w2c.messages import Empty
from w2c.private_system import running_system
from w2c_evaluation.demo.layout import draw_layout
from w2c_evaluation.demo.operator import LineResult, Operator, ScenarioError
from w2c_evaluation.demo.picture import draw_target
from w2c_evaluation.demo.scenario import SCENARIO_A, Line
from w2c_evaluation.demo.summary import make_summary, write_summary

log = logging.getLogger("w2c.demo")

FORCE_LEAST_N = 10.0
ERROR_MOST_M = 0.03


@dataclass(frozen=True)
class RunOptions:
    """How to run the scenario."""

    directory: Path
    seed: int
    lock_step: bool
    quiet: bool


def run_scenario(options: RunOptions) -> dict[str, Any]:
    """Play scenario (a) once and return its summary, whose `problem` is empty on success."""
    options.directory.mkdir(parents=True, exist_ok=True)
    scene = options.directory / "scene.json"
    layout = draw_layout(options.seed, scene)
    log.info("%s", layout)
    flags = ["--scene", str(scene), "--seed", str(options.seed)]
    if options.lock_step:
        # Nobody watches the stream, and time passes as slowly as the pictures let it.
        flags += ["--lock-step", "--with-flags", "camera:--rate 1"]
    results: list[LineResult] = []
    problem, fell, status = "", False, None
    with running_system(options.directory, flags, quiet=options.quiet) as system:
        config = ServiceConfig(robot=system.robot, router=system.router)
        with connect(config, "evaluation", [system.router]) as bus:
            description = bus.call(topics.DESCRIBE, Empty(), timeout_s=20.0).message
            operator = Operator(bus, description, layout.places)
            try:
                operator.wait_until_it_stands()
                for line in SCENARIO_A:
                    results.append(operator.perform(line))
                    _report(line, results[-1])
                    _keep_pictures(operator, line, options.directory)
                problem = judge(results, fell=operator.fell)
                status = operator.status()
            except (ScenarioError, W2CError) as error:
                problem = str(error)
                _keep_picture(operator, options.directory / "failed.jpg")
            fell = operator.fell
    summary = make_summary(
        results,
        status,
        fell=fell,
        recording=str(options.directory / "session.mcap"),
        problem=problem,
    )
    write_summary(summary, options.directory / "summary.json")
    return summary


def judge(results: list[LineResult], *, fell: bool) -> str:
    """Return what is wrong with a finished scenario; empty = a success.

    Success: the right hand truly carries at least FORCE_LEAST_N, the left hand is truly within
    ERROR_MOST_M of where it should be, and nothing fell.
    """
    problems = ["the robot fell"] if fell else []
    for result in results:
        if result.event is None:
            continue
        if result.event.task == "contact" and not result.force_n >= FORCE_LEAST_N:
            problems.append(f"the hand carries {result.force_n:.1f} N, at least {FORCE_LEAST_N:g}")
        if result.event.task == "reach" and not result.error_m <= ERROR_MOST_M:
            problems.append(
                f"the hand is {result.error_m * 1e3:.0f} mm from its point, "
                f"at most {ERROR_MOST_M * 1e3:.0f}"
            )
    tasks = {result.event.task for result in results if result.event is not None}
    problems += [f"no {task} took place" for task in ("contact", "reach") if task not in tasks]
    return "; ".join(problems)


def _report(line: Line, result: LineResult) -> None:
    log.info('"%s" -> [%s] %s', line.text, result.turn.module, result.turn.reply)
    if result.event is not None:
        log.info(
            "%s %s; true force %.1f N, true error %.1f mm",
            result.event.end_effector,
            result.event.state,
            result.force_n,
            result.error_m * 1e3,
        )


def _keep_pictures(operator: Operator, line: Line, directory: Path) -> None:
    if line.picture:
        _keep_picture(operator, directory / f"{line.picture}.jpg")
    frame = operator.frame_of_target()
    if line.expect == "target" and frame is not None and operator.target is not None:
        name = f"target-{line.text.split()[0].lower()}-{operator.target.corrections}.jpg"
        (directory / name).write_bytes(draw_target(frame.jpeg, operator.target))


def _keep_picture(operator: Operator, path: Path) -> None:
    try:
        path.write_bytes(operator.take_picture("side"))
    except W2CError as error:
        log.warning("no picture %s: %s", path.name, error)
