"""What tests of perception share."""

from collections.abc import Iterator

import pytest

from support.perceiving import Rig, perceiving


@pytest.fixture
def rig() -> Iterator[Rig]:
    with perceiving() as rig:
        yield rig
