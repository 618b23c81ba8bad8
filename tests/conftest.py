"""Options and fixtures of all tests."""

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that accepts changed bytes on the wire."""
    parser.addoption(
        "--accept-golden", action="store_true", help="write the golden bytes of the messages anew"
    )
