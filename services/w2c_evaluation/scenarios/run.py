"""One run: a layout, a private system in lock step, the conversation, the verdict."""

import logging
import shutil
import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from w2c import topics
from w2c.bus import Bus
from w2c.bus.zenoh_bus import connect
from w2c.config import ServiceConfig
from w2c.errors import W2CError
from w2c.library import library
from w2c.messages import Empty
from w2c.private_system import running_system
from w2c.system import SystemFile
from w2c_evaluation.scenarios.cause import cause_of_turn, find_cause
from w2c_evaluation.scenarios.conversation import Conversation
from w2c_evaluation.scenarios.experiments import Experiment
from w2c_evaluation.scenarios.film import Film
from w2c_evaluation.scenarios.hits import Robot
from w2c_evaluation.scenarios.judge import REACHED_M, Verdict, judge
from w2c_evaluation.scenarios.phrase_book import PhraseBook
from w2c_evaluation.scenarios.record import Boxes, Played, PromptRun, RunResult, Words
from w2c_evaluation.scenarios.scenario import Scenario
from w2c_evaluation.scenarios.scripted_words import ScriptedWords
from w2c_evaluation.scenarios.true_boxes import TrueGrounding
from w2c_evaluation.scenarios.truth_log import TruthLog

log = logging.getLogger("w2c.scenarios")

RECORDING, PICTURES = "session.mcap", "pictures"


@dataclass(frozen=True)
class Afterwards:
    """What is done after the last prompt, without words."""

    title: str
    """What has happened when it went well"""
    act: Callable[[Bus, TruthLog], str]
    """Returns what went wrong; empty = nothing"""


@dataclass(frozen=True)
class RunOptions:
    """How to run."""

    directory: Path
    """Of this run"""
    boxes: Boxes
    words: Words
    keep: bool
    """Keep recordings of successes too"""
    afterwards: Afterwards | None = None


def run_scenario(experiment: Experiment, seed: int, options: RunOptions) -> RunResult:
    """Play a scenario once and judge it. A failure is a result, not an error."""
    start = time.monotonic()
    shutil.rmtree(options.directory, ignore_errors=True)
    options.directory.mkdir(parents=True)
    scenario, played, verdict = Scenario(experiment.name, ()), Played(), None
    try:
        scene = options.directory / "scene.json"
        layout = experiment.draw_layout(seed, scene)
        log.info("scenario %s, seed %d: %s", experiment.name, seed, layout)
        scenario = experiment.read(scene)
        played, verdict = _play(scenario, seed, scene, options)
    except W2CError as error:
        played.system_problem = str(error)
    result = conclude(scenario, seed, played, verdict)
    recording = options.directory / RECORDING
    if result.succeeded and not options.keep:
        recording.unlink(missing_ok=True)
    return RunResult(
        **{name: getattr(result, name) for name in RunResult.__struct_fields__}
        | {
            "recording": f"{options.directory.name}/{RECORDING}" if recording.exists() else "",
            "images": f"{options.directory.name}/{PICTURES}",
            "seconds": time.monotonic() - start,
        }
    )


def conclude(scenario: Scenario, seed: int, played: Played, verdict: Verdict | None) -> RunResult:
    """Return the result of what was played; without a verdict the system failed."""
    problems = () if verdict is None else verdict.problems
    for problem in (played.afterwards_problem, played.system_problem):
        problems = (problem, *problems) if problem else problems
    succeeded = verdict is not None and not problems
    return RunResult(
        scenario=scenario.name,
        seed=seed,
        succeeded=succeeded,
        fell=verdict is not None and verdict.fell,
        unconfirmed_motions=0 if verdict is None else verdict.unconfirmed_motions,
        problems=problems,
        cause="" if succeeded else _cause(scenario, played, verdict),
        corrections=tuple(run.corrections for run in played.prompts),
        place_errors_mm=_millimetres(() if verdict is None else verdict.place_errors_m),
        hand_errors_mm=_millimetres(() if verdict is None else verdict.hand_errors_m),
        support_force_n=() if verdict is None else verdict.support_n,
        turns=tuple(tuple(run.turns) for run in played.prompts),
        wrong_turns=count_wrong_turns(scenario, played.prompts),
    )


def count_wrong_turns(scenario: Scenario, runs: Sequence[PromptRun]) -> dict[str, int]:
    """Return how many turns were answered wrongly, by cause."""
    causes = Counter(
        cause
        for prompt, run in zip(scenario.prompts, runs, strict=False)
        for turn in run.turns
        if (cause := cause_of_turn(turn, prompt.meaning)) is not None
    )
    return {str(cause): count for cause, count in causes.items()}


def _cause(scenario: Scenario, played: Played, verdict: Verdict | None) -> str:
    """Return the cause of the first prompt that failed; what all of the robot did is control."""
    if verdict is None or played.system_problem:
        return "system"
    failed = [index for index, texts in enumerate(verdict.prompt_problems) if texts]
    if played.afterwards_problem:
        return "control"
    # A fall or a hit in a run whose prompts went well is the controller's.
    index = failed[0] if failed else len(scenario.prompts) - 1
    run = played.prompts[index] if index < len(played.prompts) else PromptRun()
    right_place = verdict.place_errors_m[index] <= REACHED_M
    return find_cause(scenario.prompts[index], run, right_place=right_place)


def _play(
    scenario: Scenario, seed: int, scene: Path, options: RunOptions
) -> tuple[Played, Verdict]:
    witness = library("witness")(scene)
    objects = {item.name: item.phrases() for item in witness.objects}
    book = PhraseBook(objects, scenario.phrases())
    flags = ["--lock-step", "--scene", str(scene), "--seed", str(seed)]
    # Nobody looks while the robot moves: the camera draws when the operator looks.
    flags += ["--with-flags", "camera:--rate 0", "--without", "console"]
    flags += ["grounding"] if options.boxes == "truth" else []
    flags += ["llm"] if options.words == "scripted" else []
    with ExitStack() as stack:
        system = stack.enter_context(running_system(options.directory, flags, quiet=True))
        truth = stack.enter_context(TruthLog(_connect(stack, system, "evaluation"), witness))
        bus = _connect(stack, system, "operator")
        words = ScriptedWords(_connect(stack, system, "llm")) if options.words != "model" else None
        if options.boxes == "truth":
            TrueGrounding(_connect(stack, system, "grounding"), truth, book)
        description = bus.call(topics.DESCRIBE, Empty(), timeout_s=20.0).message
        film = Film(options.directory / PICTURES)
        rng = np.random.default_rng([seed, ord(scenario.name[0])])
        conversation = Conversation(bus, truth, book, film, rng=rng, words=words)
        try:
            conversation.play(scenario)
            if options.afterwards is not None and conversation.succeeded(scenario):
                problem = options.afterwards.act(bus, truth)
                conversation.played.afterwards_problem = problem
                conversation.show(problem or options.afterwards.title)
        except W2CError as error:
            conversation.played.system_problem = str(error)
        robot = Robot(witness.links, witness.effectors, description.hand_radius)
        return conversation.played, judge(scenario, conversation.played, truth.samples, robot)


def _connect(stack: ExitStack, system: SystemFile, service: str) -> Bus:
    config = ServiceConfig(robot=system.robot, router=system.router)
    return stack.enter_context(connect(config, service, [system.router]))


def _millimetres(values: tuple[float, ...]) -> tuple[float, ...]:
    """Return lengths that are known [mm]."""
    return tuple(round(1e3 * value, 1) for value in values if np.isfinite(value))
