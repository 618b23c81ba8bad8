"""`w2c dialogue batch`: the dialogue's modules on lines of JSON."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, BinaryIO

import msgspec
import tyro
from rich.console import Console
from rich.progress import track

from w2c.bus import Bus
from w2c.bus.zenoh_bus import connect
from w2c.config import parse
from w2c.errors import ConfigError, ConnectionFailedError, W2CError
from w2c.private_system import running_system
from w2c.system import Connection, service_config
from w2c_dialogue.batch.answering import Answering
from w2c_dialogue.batch.lines import Answer, decode, id_of
from w2c_dialogue.prompts.sets import PROMPT_SETS, PromptSetName
from w2c_dialogue.remote import RemoteServices

NOT_NEEDED = (
    "robot", "camera", "controller", "grounding", "perception", "recorder", "dialogue", "console",
)  # fmt: skip
"""Of the simulation's processes: a batch needs a language model only."""


class BatchConfig(Connection, frozen=True, kw_only=True):
    """Answer questions about utterances with the modules that the robot's dialogue runs.

    One JSON object a line, in and out. Starts a language model of its own and stops it; with
    --attach it asks the one of the running system. A line that cannot be answered gives a line
    {"id", "error"}, and the rest goes on.
    """

    in_: Annotated[str, tyro.conf.arg(name="in")]
    """File of questions; - = standard input."""
    out: str
    """File of answers, in the same order; - = standard output."""
    prompts: PromptSetName = "embedded"
    """Prompt set: `embedded` for the model of this repository, `large` for any general model."""
    model: str = ""
    """GGUF file; empty = the embedded model."""
    seed: int = 0
    """Seed of the language model's answers."""
    model_timeout: Annotated[float, msgspec.Meta(gt=0, le=600)] = 30.0
    """Deadline of one question to the language model [s]."""
    attach: bool = False
    """Use the system that runs here, or the one of --robot and --router."""


def batch(arguments: list[str] | None = None) -> int:
    """Answer a file. Exit status 0 when every line was read, those with an error included."""
    config = parse(BatchConfig, arguments or [], program="w2c dialogue batch")
    lines = _read(config.in_)
    failures = 0
    progress = Console(stderr=True)
    with _open(config.out) as out, _language_model(config) as bus:
        services = RemoteServices(bus, seed=config.seed, model_timeout_s=config.model_timeout)
        answering = Answering(services, PROMPT_SETS[config.prompts]())
        for line in track(lines, "lines", console=progress, disable=not progress.is_terminal):
            answer = answer_line(answering, line)
            failures += "error" in answer
            out.write(msgspec.json.encode(answer) + b"\n")
            out.flush()
    if failures:
        progress.print(f"{failures} of {len(lines)} lines could not be answered: see their error")
    return 0


def answer_line(answering: Answering, line: bytes) -> Answer:
    """Return what is written for a line: an answer, or an error with its reason.

    Raises:
        ConnectionFailedError: there is no language model any more; no line could be answered.
    """
    try:
        question = decode(line)
    except (msgspec.MsgspecError, ValueError) as error:
        return {"id": id_of(line), "error": f"not a question: {error}"}
    try:
        return {"id": question.id, **answering.answer(question)}
    except ConnectionFailedError:
        raise
    except W2CError as error:
        return {"id": question.id, "error": str(error)}


def _read(name: str) -> list[bytes]:
    try:
        data = Path("/dev/stdin" if name == "-" else name).read_bytes()
    except OSError as error:
        raise ConfigError(f"{name} cannot be read: {error.strerror}; give --in FILE") from error
    return [line for line in data.splitlines() if line.strip()]


@contextmanager
def _open(name: str) -> Iterator[BinaryIO]:
    try:
        with Path("/dev/stdout" if name == "-" else name).open("wb") as file:
            yield file
    except OSError as error:
        raise ConfigError(
            f"{name} cannot be written: {error.strerror}; give another --out"
        ) from error


@contextmanager
def _language_model(config: BatchConfig) -> Iterator[Bus]:
    """Yield a bus on which a language model answers."""
    if config.attach:
        service = service_config(config)
        with connect(service, "evaluation", [service.router]) as bus:
            yield bus
        return
    flags = ["--without", *NOT_NEEDED]
    if config.model:
        flags += ["--with-flags", f"llm:--model {config.model}"]
    with (
        tempfile.TemporaryDirectory(prefix="w2c-batch-") as directory,
        running_system(Path(directory), flags, quiet=True) as system,
    ):
        service = service_config(Connection(robot=system.robot, router=system.router))
        with connect(service, "evaluation", [service.router]) as bus:
            yield bus
