"""The two streams of the page: pictures on request, and news."""

import asyncio
import struct
import time
import uuid
from collections.abc import Callable
from types import TracebackType
from typing import Annotated, Protocol, Self

import msgspec
from starlette.types import Message
from starlette.websockets import WebSocket, WebSocketDisconnect

from w2c.clock import Clock
from w2c_console.page import AdviceNews, AreaNews, Entry, Hello, Panel, PictureHeader
from w2c_console.view import Scene

ANSWER_WITHIN_S = 1.0
"""A page that hears nothing for longer knows that the connection is dead"""
PANEL_PERIOD_S = 0.5
UNSUPPORTED = 1003


class ConsoleView(Protocol):
    """What the page may know; `ConsoleModel` is one."""

    def listen(self, callback: Callable[[], None]) -> Callable[[], None]:
        """Call back, in any thread, when there is something new. Returns the way to end it."""

    def pin(self, stamp_ns: int) -> None:
        """Keep a picture."""

    def scene(self, *, live: bool) -> Scene:
        """Return what the operator should see."""

    def header(self, scene: Scene, now_ns: int) -> PictureHeader:
        """Return what is said of a scene."""

    def entries(self, after: int) -> list[Entry]:
        """Return the chat after an entry."""

    def advice(self) -> AdviceNews | None:
        """Return what was last said of a target besides its place."""

    def area(self) -> AreaNews | None:
        """Return where a hand may go, in the picture that was last asked about."""

    def panel(self, now_ns: int) -> Panel:
        """Return the state of everything."""


class PictureWish(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The page asks for what it does not have yet."""

    shown: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Sequence of the picture on the screen; 0: none"""
    live: bool = False
    """The newest picture, even if the target cannot be drawn on it"""


class NewsWish(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The page says what it has."""

    boot: str = ""
    after: Annotated[int, msgspec.Meta(ge=0)] = 0
    """The last entry of the chat that it has"""


class _Wakeup:
    """Wakes a coroutine when another thread changed the model."""

    def __init__(self, view: ConsoleView) -> None:
        self._view = view
        self._event = asyncio.Event()
        self._loop = asyncio.get_running_loop()
        self._forget: Callable[[], None] = lambda: None

    def __enter__(self) -> Self:
        self._forget = self._view.listen(self._set)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._forget()

    def clear(self) -> None:
        """Forget earlier changes. Call it before reading the model, so that none is missed."""
        self._event.clear()

    async def wait(self, timeout_s: float) -> None:
        """Return at the next change, or after the time-out."""
        try:
            await asyncio.wait_for(self._event.wait(), timeout_s)
        except TimeoutError:
            return

    def _set(self) -> None:
        try:
            self._loop.call_soon_threadsafe(self._event.set)
        except RuntimeError:  # the server's loop ended meanwhile: nobody waits any more
            return


class Streams:
    """Serves the WebSockets of all pages."""

    def __init__(self, view: ConsoleView, clock: Clock, *, title: str, robot: str) -> None:
        self._view = view
        self._clock = clock
        self._hello = Hello(boot=uuid.uuid4().hex, title=title, robot=robot)

    async def camera(self, socket: WebSocket) -> None:
        """Answer each wish with the newest picture: a slow page skips some, and delays nobody."""
        await socket.accept()
        sent: Scene | None = None
        try:
            with _Wakeup(self._view) as wakeup:
                while True:
                    wish = msgspec.json.decode(await socket.receive_text(), type=PictureWish)
                    sent = await self._next_scene(wish, sent, wakeup)
                    await socket.send_bytes(self._packet(sent, wish.shown))
        except WebSocketDisconnect:
            return
        except msgspec.MsgspecError as error:
            await socket.close(UNSUPPORTED, str(error)[:100])

    async def news(self, socket: WebSocket) -> None:
        """Send the chat from where the page left off, and the state of everything."""
        await socket.accept()
        try:
            wish = msgspec.json.decode(await socket.receive_text(), type=NewsWish)
            await _send(socket, self._hello)
            last = wish.after if wish.boot == self._hello.boot else 0
            ended = asyncio.ensure_future(
                socket.receive()
            )  # the page says nothing more but goodbye
            try:
                await self._tell_news(socket, last, ended)
            finally:
                ended.cancel()
        except WebSocketDisconnect:
            return
        except msgspec.MsgspecError as error:
            await socket.close(UNSUPPORTED, str(error)[:100])

    async def _tell_news(
        self, socket: WebSocket, last: int, ended: "asyncio.Future[Message]"
    ) -> None:
        panel_due = time.monotonic()
        told: dict[type, AdviceNews | AreaNews] = {}
        with _Wakeup(self._view) as wakeup:
            while not ended.done():
                wakeup.clear()
                for entry in self._view.entries(last):
                    await _send(socket, entry)
                    last = entry.id
                for news in (self._view.area(), self._view.advice()):
                    if news is not None and news != told.get(type(news)):
                        await _send(socket, news)
                        told[type(news)] = news
                if time.monotonic() >= panel_due:
                    await _send(socket, self._view.panel(self._clock.now_ns()))
                    panel_due = time.monotonic() + PANEL_PERIOD_S
                await wakeup.wait(max(0.0, panel_due - time.monotonic()))

    async def _next_scene(self, wish: PictureWish, sent: Scene | None, wakeup: _Wakeup) -> Scene:
        """Return a scene that differs from the last one sent, or the same one after a while."""
        deadline = time.monotonic() + ANSWER_WITHIN_S
        while True:
            wakeup.clear()
            scene = self._view.scene(live=wish.live)
            remaining = deadline - time.monotonic()
            if remaining <= 0 or _sequence(scene) != wish.shown or scene != sent:
                return scene
            await wakeup.wait(remaining)

    def _packet(self, scene: Scene, shown: int) -> bytes:
        """Return the header's length (uint32, big endian), the header (JSON), and a JPEG if new."""
        header = msgspec.json.encode(self._view.header(scene, self._clock.now_ns()))
        known = scene.frame is None or scene.frame.sequence == shown
        jpeg = b"" if known or scene.frame is None else scene.frame.jpeg
        return struct.pack(">I", len(header)) + header + jpeg


def _sequence(scene: Scene) -> int:
    return 0 if scene.frame is None else scene.frame.sequence


async def _send(socket: WebSocket, message: Hello | Panel | Entry | AdviceNews | AreaNews) -> None:
    await socket.send_text(msgspec.json.encode(message).decode())
