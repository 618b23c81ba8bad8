"""A page's side of the console."""

from collections.abc import Iterator

import pytest

from fakes.console_operator import Page


@pytest.fixture
def page() -> Iterator[Page]:
    page = Page()
    with page.client:
        yield page
