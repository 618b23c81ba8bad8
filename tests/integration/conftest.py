"""A running system that the tests of one module share."""

from collections.abc import Iterator

import pytest

from support.running import RunningSystem, run_system


@pytest.fixture(scope="module")
def system(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningSystem]:
    """Every process of the simulation, in real time, in scenario (a)."""
    with run_system(tmp_path_factory.mktemp("system")) as running:
        yield running
