"""A browser, and a page whose services are fakes."""

import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import sync_playwright

from fakes.console_world import ConsoleWorld, Heart
from support.ports import free_port
from w2c.clock import RealClock
from w2c_console.config import ConsoleConfig
from w2c_console.node import ConsoleNode
from w2c_console.stop import BusLine

CHROMIUM = Path("/usr/bin/chromium")
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-quic",
]
TIMEOUT_MS = 15_000


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Debian's chromium with its own profile; one for all tests, as a start takes seconds."""
    if not CHROMIUM.exists():
        pytest.skip(f"{CHROMIUM} is not installed: apt-get install chromium")
    with sync_playwright() as playwright:
        context = playwright.chromium.launch_persistent_context(
            tmp_path_factory.mktemp("profile"), executable_path=str(CHROMIUM), args=FLAGS
        )
        context.set_default_timeout(TIMEOUT_MS)
        yield context
        context.close()


class Console:
    """A console that can be stopped and started again at the same port."""

    def __init__(self, world: ConsoleWorld) -> None:
        self.world = world
        self.port = free_port()
        self._node: ConsoleNode | None = None
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def url(self) -> str:
        """Where the page is."""
        return f"http://127.0.0.1:{self.port}/"

    def start(self) -> None:
        """Serve."""
        config = ConsoleConfig(robot="talos", port=self.port, title="Lean on me")
        bus = self.world.hub.connect("console")
        self._node = ConsoleNode(config, bus, RealClock(), [BusLine(bus)])
        self._node.configure()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._node.run, args=(self._stop,))
        self._thread.start()

    def end(self) -> None:
        """Serve no longer."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(timeout=5.0)
        if self._node is not None:
            self._node.close()


@pytest.fixture
def world() -> Iterator[ConsoleWorld]:
    """The services around the console."""
    world = ConsoleWorld()
    heart = Heart(world.publish_health, world.robot.publish, world.publish_controller)
    yield world
    heart.close()
    world.close()


@pytest.fixture
def console(world: ConsoleWorld) -> Iterator[Console]:
    """The console of this test."""
    console = Console(world)
    console.start()
    yield console
    console.end()


@pytest.fixture
def open_page(browser: Any, console: Console) -> Iterator[Callable[..., Any]]:
    """Return how to open the page, connected; errors of its scripts fail the test."""
    pages: list[Any] = []
    errors: list[str] = []

    def open_one(
        width: int = 1280, height: int = 900, prepare: Callable[[Any], None] = lambda _: None
    ) -> Any:
        page = browser.new_page()
        prepare(page)
        pages.append(page)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.set_viewport_size({"width": width, "height": height})
        page.goto(console.url)
        page.get_by_role("status", name="Connection").get_by_text(
            "connected", exact=True
        ).wait_for()
        return page

    yield open_one
    for page in pages:
        page.close()
    assert errors == []
