"""One session, written once, for all tests that only read it."""

from pathlib import Path

import pytest

from support.sessions import conversation


@pytest.fixture(scope="session")
def session_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The conversation of `support.sessions`; nobody writes into it."""
    return conversation().write(tmp_path_factory.mktemp("session") / "session.mcap")
