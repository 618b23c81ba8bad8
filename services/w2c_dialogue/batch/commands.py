"""`w2c dialogue batch`: the dialogue's modules on lines of JSON."""

import os
import shlex
import shutil
import tempfile
import time
from codecs import BOM_UTF8
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
from w2c.errors import ConfigError, ConnectionFailedError, ProcessError, W2CError
from w2c.private_system import running_system
from w2c.system import Connection, service_config
from w2c_dialogue.batch.answering import Answering
from w2c_dialogue.batch.lines import Answer, decode, field_of
from w2c_dialogue.batch.patience import Patience
from w2c_dialogue.batch.tally import Tally
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
    resume: bool = False
    """Go on behind the answers that --out holds already."""
    json: str = ""
    """File for how many lines of each task were answered, and how long they took."""


def batch(arguments: list[str] | None = None) -> int:
    """Answer a file. Exit status 0 when every line was read, those with an error included."""
    config = parse(BatchConfig, arguments or [], program="w2c dialogue batch")
    _check_model(config)
    lines = _read(config.in_)
    done = _resume(config.out, lines) if config.resume else 0
    tally = Tally()
    progress = Console(stderr=True)
    if done < len(lines):
        with _open(config.out, append=done > 0) as out, _language_model(config) as bus:
            services = RemoteServices(bus, seed=config.seed, model_timeout_s=config.model_timeout)
            patience = Patience()
            answering = Answering(services, PROMPT_SETS[config.prompts]())
            for line in track(
                lines[done:], "lines", console=progress, disable=not progress.is_terminal
            ):
                started = time.monotonic()
                answer = answer_line(answering, line, patience)
                tally.add(line, answer, time.monotonic() - started)
                out.write(msgspec.json.encode(answer) + b"\n")
                out.flush()
    if config.json:
        with _open(config.json) as file:
            file.write(msgspec.json.format(msgspec.json.encode(tally.results(config.seed))))
    if tally.failures:
        progress.print(
            f"{tally.failures} of {len(lines) - done} lines could not be answered: see their error"
        )
    return 0


def _check_model(config: BatchConfig) -> None:
    """Refuse a model that cannot be started, before anything is.

    Raises:
        ConfigError: says why.
    """
    if config.model and config.attach:
        raise ConfigError("--model is for a language model of its own: leave it out with --attach")
    if config.model and not Path(config.model).is_file():
        raise ConfigError(f"there is no file {config.model}; give a GGUF file with --model")


def answer_line(answering: Answering, line: bytes, patience: Patience | None = None) -> Answer:
    """Return what is written for a line: an answer, or an error with its reason.

    Args:
        answering: Answers questions.
        line: Which may be none.
        patience: With a language model that does not answer now; None = with none.

    Raises:
        ConnectionFailedError: there is no language model any more; no line could be answered.
    """
    try:
        question = decode(line)
    except ValueError as error:
        return {"id": field_of(line, "id"), "error": f"not a question: {error}"}
    try:
        asked = (patience or Patience(())).ask(lambda: answering.answer(question))
        return {"id": question.id, **asked}
    except ConnectionFailedError:
        raise
    except W2CError as error:
        return {"id": question.id, "error": str(error)}


def _read(name: str) -> list[bytes]:
    data = _bytes_of("/dev/stdin" if name == "-" else name)
    return [line for line in data.removeprefix(BOM_UTF8).splitlines() if line.strip()]


def _bytes_of(name: str) -> bytes:
    try:
        return Path(name).read_bytes()
    except OSError as error:
        raise ConfigError(
            f"{name} cannot be read: {error.strerror}; choose another file"
        ) from error


def _resume(name: str, lines: list[bytes]) -> int:
    """Return how many lines a file answers already; an answer that was cut short is dropped.

    Raises:
        ConfigError: it answers other lines, or cannot be read.
    """
    path = Path(name)
    if name == "-" or not path.exists():
        return 0
    data = _bytes_of(name)
    whole = data[: data.rfind(b"\n") + 1]
    answers = whole.splitlines()
    for number, answer in enumerate(answers, 1):
        wanted = field_of(lines[number - 1], "id") if number <= len(lines) else None
        if number > len(lines) or field_of(answer, "id") != wanted:
            raise ConfigError(
                f"line {number} of {name} answers another file than --in; leave out --resume to "
                "begin anew, or choose another --out"
            )
    os.truncate(path, len(whole))
    return len(answers)


@contextmanager
def _open(name: str, *, append: bool = False) -> Iterator[BinaryIO]:
    try:
        with Path("/dev/stdout" if name == "-" else name).open("ab" if append else "wb") as file:
            yield file
    except OSError as error:
        raise ConfigError(
            f"{name} cannot be written: {error.strerror}; choose another file"
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
        flags += ["--with-flags", f"llm:--model {shlex.quote(config.model)}"]
    with _run_directory() as directory, running_system(directory, flags, quiet=True) as system:
        service = service_config(Connection(robot=system.robot, router=system.router))
        with connect(service, "evaluation", [service.router]) as bus:
            yield bus


@contextmanager
def _run_directory() -> Iterator[Path]:
    """Yield an empty directory; it stays, with its logs, where a process did not start."""
    path = Path(tempfile.mkdtemp(prefix="w2c-batch-"))
    failed = False
    try:
        yield path
    except ProcessError:
        failed = True
        raise
    finally:
        if not failed:
            shutil.rmtree(path, ignore_errors=True)
