"""Options of all tests, and how two workers share them."""

import fcntl
import hashlib
import os
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

# How long an example takes says how busy the machine is, not whether the code is right.
settings.register_profile("w2c", deadline=None)
settings.load_profile("w2c")

ROOT = Path(__file__).parents[1]
REAL_TIME = "real_time"
_LOCK = Path(tempfile.gettempdir()) / f"w2c-{hashlib.sha256(bytes(ROOT)).hexdigest()[:12]}.lock"
"""Shared by the tests of a worker, taken alone by one in real time"""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that accepts changed bytes on the wire."""
    parser.addoption(
        "--accept-golden", action="store_true", help="write the golden bytes of the messages anew"
    )


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put what runs in real time last: by then the other worker has little left to do."""
    items.sort(key=lambda item: item.get_closest_marker(REAL_TIME) is not None)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Run nothing beside a test in real time: it waits for the other worker, and that for it."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        return (yield)
    alone = item.get_closest_marker(REAL_TIME) is not None
    with _LOCK.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX if alone else fcntl.LOCK_SH)
        try:
            return (yield)
        finally:
            fcntl.flock(file, fcntl.LOCK_UN)  # closing does not, while a forked child has it too


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> object:
    """Keep the tests of a file on one worker, and all that run in real time."""
    from xdist.scheduler import LoadFileScheduling

    class Scheduler(LoadFileScheduling):  # type: ignore[misc]  # xdist has no types
        def _split_scope(self, nodeid: str) -> str:
            file: str = super()._split_scope(nodeid)
            return REAL_TIME if _is_real_time(file) else file

    return Scheduler(config, log)


@cache
def _is_real_time(file: str) -> bool:
    """Tell whether the tests of a file bear the mark: here they have not been imported."""
    return f"pytest.mark.{REAL_TIME}" in (ROOT / file).read_text()
