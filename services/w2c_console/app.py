"""The web application: one page, two streams, five requests."""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Annotated, Any, TypeVar

import msgspec
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles

from w2c.clock import Clock
from w2c.errors import DeadlineError, MessageError, RefusedError, UnavailableError, W2CError
from w2c.messages import ConfirmRequest, PointRequest, SayRequest
from w2c.messages.base import RobotBoot
from w2c_console.guard import Guard
from w2c_console.operator import Operator
from w2c_console.sockets import ConsoleView, Streams

STATIC = Path(__file__).parent / "static"
MAX_BODY = 16_384
STOPS_AT_ONCE = 8
STATUS: dict[type[W2CError], int] = {
    MessageError: 400,
    RefusedError: 409,
    UnavailableError: 503,
    DeadlineError: 504,
}

StampText = Annotated[str, msgspec.Meta(pattern=r"^(-1|\d{1,19})$")]
T = TypeVar("T")


class SayBody(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the page sends with an utterance."""

    text: Annotated[str, msgspec.Meta(min_length=1, max_length=500)]
    frame_stamp: StampText
    robot_boot: RobotBoot = ""
    target_id: Annotated[str, msgspec.Meta(max_length=100)] = ""


class ConfirmBody(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the page sends with a confirmation."""

    target_id: Annotated[str, msgspec.Meta(min_length=1, max_length=100)]


class PointBody(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the page sends with a click on the picture."""

    u: Annotated[float, msgspec.Meta(ge=0, le=8192)]
    v: Annotated[float, msgspec.Meta(ge=0, le=8192)]
    frame_stamp: StampText
    robot_boot: RobotBoot = ""


class ErrorBody(msgspec.Struct, frozen=True):
    """Why a request was not done."""

    code: str
    message: str


class Requests:
    """What the page asks the operator's hands to do."""

    def __init__(self, view: ConsoleView, operator: Operator) -> None:
        self._view = view
        self._operator = operator
        # Of its own, so that answers that take long can never use up the threads that a stop needs.
        self._stop_pool = ThreadPoolExecutor(STOPS_AT_ONCE, thread_name_prefix="stop")

    async def say(self, request: Request) -> Response:
        """Forward an utterance, with the picture and the target that were on the screen."""
        body = await _body(request, SayBody)
        self._view.pin(int(body.frame_stamp))
        say = SayRequest(
            text=body.text,
            frame_stamp_ns=int(body.frame_stamp),
            robot_boot_id=body.robot_boot,
            target_id=body.target_id,
        )
        return await _answer(self._operator.say, say)

    async def confirm(self, request: Request) -> Response:
        """Forward the confirmation of the target that was on the screen."""
        body = await _body(request, ConfirmBody)
        return await _answer(self._operator.confirm, ConfirmRequest(target_id=body.target_id))

    async def point(self, request: Request) -> Response:
        """Forward a click, with the picture that was clicked."""
        body = await _body(request, PointBody)
        self._view.pin(int(body.frame_stamp))
        point = PointRequest(
            u=body.u,
            v=body.v,
            frame_stamp_ns=int(body.frame_stamp),
            robot_boot_id=body.robot_boot,
        )
        return await _answer(self._operator.point, point)

    async def stop(self, _: Request) -> Response:
        """Make the robot hold. Takes no body: a form without any script can send it."""
        loop = asyncio.get_running_loop()
        outcome = await loop.run_in_executor(self._stop_pool, self._operator.stop, "console")
        return _json(outcome, 200 if outcome.acknowledged else 504)

    async def resume(self, _: Request) -> Response:
        """Let the robot follow commands again."""
        reply = await run_in_threadpool(self._operator.resume)
        return _json({"mode": reply.mode, "stamp": str(reply.stamp_ns)})


def make_app(
    view: ConsoleView,
    operator: Operator,
    clock: Clock,
    *,
    title: str,
    robot: str,
    allowed_hosts: frozenset[str] | None,
) -> Starlette:
    """Return the application.

    Args:
        view: what the page may know.
        operator: what the page may do.
        clock: the clock that ages are computed with.
        title: heading of the page.
        robot: id of the robot.
        allowed_hosts: names the page may be opened under; None = any.
    """
    streams = Streams(view, clock, title=title, robot=robot)
    does = Requests(view, operator)
    acts = (does.say, does.confirm, does.point, does.stop, does.resume)
    return Starlette(
        routes=[
            Route("/", _index),
            WebSocketRoute("/ws/camera", streams.camera),
            WebSocketRoute("/ws/news", streams.news),
            *(Route(f"/api/{act.__name__}", act, methods=["POST"]) for act in acts),
            Mount("/static", StaticFiles(directory=STATIC)),
        ],
        middleware=[Middleware(Guard, allowed_hosts=allowed_hosts)],
        exception_handlers={W2CError: _failure},
    )


async def _index(_: Request) -> Response:
    return FileResponse(STATIC / "index.html")


async def _body(request: Request, body_type: type[T]) -> T:
    """Return the validated body. Raises MessageError."""
    if not request.headers.get("content-type", "").startswith("application/json"):
        raise MessageError("expected a body of type application/json")
    data = bytearray()
    async for chunk in request.stream():
        data += chunk
        if len(data) > MAX_BODY:
            raise MessageError(f"body of more than {MAX_BODY} bytes")
    try:
        return msgspec.json.decode(bytes(data), type=body_type)
    except msgspec.MsgspecError as error:
        raise MessageError(f"not a request of this page: {error}") from error


async def _answer(call: Callable[[T], msgspec.Struct], request: T) -> Response:
    """Call off the event loop: an answer may take a minute."""
    return _json(await run_in_threadpool(call, request))


async def _failure(_: Request, error: Exception) -> Response:
    code = error.code if isinstance(error, W2CError) else "error"
    status = next((status for kind, status in STATUS.items() if isinstance(error, kind)), 502)
    return _json(ErrorBody(code, str(error)), status)


def _json(value: Any, status: int = 200) -> Response:
    return Response(msgspec.json.encode(value), status, media_type="application/json")
