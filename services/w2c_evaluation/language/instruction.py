"""A whole instruction by the service with the embedded model, and what the service takes idle."""

import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil

from w2c import topics
from w2c.bus import Bus
from w2c.bus.zenoh_bus import connect
from w2c.errors import ProcessError
from w2c.library import library
from w2c.messages import Box, ChooseRequest, CompleteRequest
from w2c.private_system import running_system
from w2c.system import Connection, service_config
from w2c.topics import SERVICES

INSTRUCTIONS = (
    "place your right hand on top of the book",
    "put your left hand to the right of the mug",
    "lean on the table with your left palm",
    "reach for the cup between the box and the kettle",
    "rest your right hand behind the red crate, please",
    "can you touch the handle of the drawer",
    "could you maybe put the left hand a bit in front of the toaster",
    "grab the screwdriver next to the pile of papers with your right hand",
    "push against the wall left of the window",
    "stand with your left foot on the lowest step",
)
IDLE_S = 3.0
"""After the last question, before the memory is read"""
_PIXELS_PER_CM = 10.0


@dataclass(frozen=True)
class Seen:
    """A thing that a picture would show."""

    phrase: str
    box: Box


@dataclass(frozen=True)
class ServiceCost:
    """What the service with the embedded model costs."""

    instructions_ms: list[float]
    """All questions of one instruction, one after the other, over the bus"""
    cpu_ms: float
    """Processor time of the service for one of them, the mean: what else runs does not count"""
    idle_memory_mb: float
    """Resident memory of the process, before the first question and after the last: the larger"""


def measure_service(rounds: int) -> ServiceCost:
    """Start the service on private ports, ask all instructions `rounds` times, and end it.

    Raises:
        ProcessError: it does not start.
    """
    with _running_model() as bus:
        process = psutil.Process(_pid_of_service(bus))
        before = process.memory_info().rss
        ask_instruction(bus, INSTRUCTIONS[0])  # the first one finds cold caches
        cpu_s = sum(process.cpu_times()[:2])
        spent = [1e3 * ask_instruction(bus, text) for _ in range(rounds) for text in INSTRUCTIONS]
        cpu_ms = 1e3 * (sum(process.cpu_times()[:2]) - cpu_s) / len(spent)
        time.sleep(IDLE_S)
        return ServiceCost(spent, cpu_ms, max(before, process.memory_info().rss) / 1e6)


def ask_instruction(bus: Bus, text: str) -> float:
    """Ask what the dialogue asks about a new instruction; return how long it took [s].

    Which module, which things and where, with which hand; and where next to it, when the place is
    beside a thing.
    """
    prompts = library("prompt_sets")["embedded"]()
    utterance = library("parse_utterance")(text)
    started = time.perf_counter()
    _choose(bus, prompts.select(utterance))
    analysis = _complete(bus, prompts.analyze(utterance))
    if analysis["position"] == "relative":
        mentions = [prompts.read_mention(entry, utterance) for entry in analysis["objects"]]
        seen = _somewhere([mention.phrase for mention in mentions])
        _complete(bus, prompts.relative(utterance, mentions, seen, _PIXELS_PER_CM))
    _complete(bus, prompts.effector(utterance))
    return time.perf_counter() - started


def _choose(bus: Bus, question: Any) -> None:
    bus.call(
        topics.CHOOSE,
        ChooseRequest(
            messages=list(question.messages),
            options=list(question.options),
            constant_messages=question.constant_messages,
        ),
    )


def _complete(bus: Bus, question: Any) -> Any:
    request = CompleteRequest(
        messages=list(question.messages),
        schema=question.schema,
        constant_messages=question.constant_messages,
    )
    return bus.call(topics.COMPLETE, request).message.value


def _somewhere(phrases: Sequence[str]) -> list[Seen]:
    """Return a box for each phrase, side by side."""
    boxes = [
        Box(left=200.0 + 300 * index, right=320.0 + 300 * index, top=300.0, bottom=400.0, score=1.0)
        for index in range(len(phrases))
    ]
    return [Seen(phrase, box) for phrase, box in zip(phrases, boxes, strict=True)]


@contextmanager
def _running_model() -> Iterator[Bus]:
    """Yield a bus on which the llm service answers, and nothing else runs."""
    others = [name for name in SERVICES if name != "llm"]
    with (
        tempfile.TemporaryDirectory(prefix="w2c-language-") as directory,
        running_system(Path(directory), ["--without", *others], quiet=True) as system,
    ):
        service = service_config(Connection(robot=system.robot, router=system.router))
        with connect(service, "evaluation", [service.router]) as bus:
            yield bus


def _pid_of_service(bus: Bus) -> int:
    health = bus.queue(topics.HEALTH)
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline:
        received = health.receive(1.0)
        if received is not None and received.message.service == "llm":
            return received.message.pid
    raise ProcessError("the llm service sends no health report; see its log")
