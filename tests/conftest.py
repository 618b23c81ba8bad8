"""Options of all tests, and how two workers share them."""

from functools import cache
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
REAL_TIME = "real_time"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that accepts changed bytes on the wire."""
    parser.addoption(
        "--accept-golden", action="store_true", help="write the golden bytes of the messages anew"
    )


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put what runs in real time last: by then the other worker has nothing left to do."""
    items.sort(key=lambda item: item.get_closest_marker(REAL_TIME) is not None)


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
