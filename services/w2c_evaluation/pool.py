"""Many independent trials on all cores, each result on disk as soon as it is there.

One JSON line a result, after one line that says what the study was asked for: a study that was
killed goes on where it was, and only with the same question.
"""

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Generic, TypeVar

import msgspec
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from w2c.errors import ConfigError, W2CError
from w2c.workers import end_with_parent

R = TypeVar("R")

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""Libraries that would start threads of their own beside one process a core"""


class ResultFile(Generic[R]):
    """The results so far of one study."""

    def __init__(self, path: Path, question: dict[str, Any], result_type: type[R]) -> None:
        self._path = path
        self._question = msgspec.to_builtins(question)
        self._type = result_type

    def start(self, *, resume: bool) -> list[R]:
        """Return what is there already; without `resume` begin anew.

        A last line that a kill cut short is dropped.

        Raises:
            ConfigError: the file answers another question.
        """
        if not resume or not self._path.exists():
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._path.write_bytes(msgspec.json.encode(self._question) + b"\n")
            return []
        whole, _, _ = self._path.read_bytes().rpartition(b"\n")
        first, *lines = whole.split(b"\n")
        try:
            before = msgspec.json.decode(first)
            results = [msgspec.json.decode(line, type=self._type) for line in lines]
        except msgspec.DecodeError as error:
            raise ConfigError(
                f"{self._path} is no file of results: {error}; choose another --run-directory"
            ) from error
        if before != self._question:
            raise ConfigError(
                f"{self._path} answers {before}, this study asks {self._question}: run it "
                "without --resume, or with the same flags"
            )
        self._path.write_bytes(whole + b"\n")
        return results

    def add(self, result: R) -> None:
        """Append a result; it is on its way to the disk when this returns. Raises W2CError."""
        try:
            with self._path.open("ab") as file:
                file.write(msgspec.json.encode(result) + b"\n")
        except OSError as error:
            raise W2CError(
                f"{self._path} cannot be written: {error.strerror}; free some space, then go on "
                f"with --resume --run-directory {self._path.parent}"
            ) from error


def run_all(
    function: Callable[..., R],
    tasks: Sequence[tuple[Any, ...]],
    *,
    workers: int,
    title: str,
    show: bool = True,
) -> Iterable[R]:
    """Yield the results of `function(*task)` as they come, with a progress bar.

    Processes are spawned, not forked: none inherits threads or state. Leaving early cancels what
    did not begin.

    Args:
        function: Of a module, so that a new process finds it.
        tasks: Arguments, one tuple a call.
        workers: Processes; 0 = one a core.
        title: Of the progress bar.
        show: Whether to draw it.
    """
    if not tasks:
        return
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    count = min(workers or os.cpu_count() or 1, len(tasks))
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(elapsed_when_finished=True),
    )
    pool = ProcessPoolExecutor(count, mp_context=get_context("spawn"), initializer=end_with_parent)
    try:
        with Progress(*columns, disable=not show) as progress:
            bar = progress.add_task(title, total=len(tasks))
            waiting: set[Future[R]] = {pool.submit(function, *task) for task in tasks}
            while waiting:
                done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
                for future in done:
                    progress.advance(bar)
                    yield future.result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
