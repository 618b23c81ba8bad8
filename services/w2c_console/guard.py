"""Keeps other web pages, open in the same browser, from driving the robot through this server.

A page of another site can send requests to 127.0.0.1. It cannot forge `Origin`, and a name that was
re-bound to 127.0.0.1 shows in `Host`: both are checked before anything else is done.
"""

from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

SECURITY_HEADERS = {
    b"content-security-policy": b"default-src 'self'; frame-ancestors 'none'",
    b"x-content-type-options": b"nosniff",
    b"cache-control": b"no-cache",
}
CLOSED_BY_POLICY = 1008


class Guard:
    """ASGI middleware: refuses foreign hosts and origins."""

    def __init__(self, app: ASGIApp, allowed_hosts: frozenset[str] | None) -> None:
        """Guard an application.

        Args:
            app: what is guarded.
            allowed_hosts: names the page may be opened under; None = any.
        """
        self._app = app
        self._allowed_hosts = allowed_hosts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request or connection."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        problem = self._problem(Headers(scope=scope))
        if problem is None:
            await self._app(scope, receive, _with_headers(send))
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": CLOSED_BY_POLICY, "reason": problem})
        else:
            await PlainTextResponse(problem, status_code=403)(scope, receive, send)

    def _problem(self, headers: Headers) -> str | None:
        host = headers.get("host", "")
        name = urlsplit(f"//{host}").hostname or ""
        if self._allowed_hosts is not None and name not in self._allowed_hosts:
            return f"host '{name}' is not served; open the page under {sorted(self._allowed_hosts)}"
        origin = headers.get("origin")
        if origin is not None and urlsplit(origin).netloc != host:
            return f"requests from pages of {origin} are refused"
        return None


def _with_headers(send: Send) -> Send:
    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            present = {name for name, _ in message["headers"]}
            message["headers"] = list(message["headers"]) + [
                item for item in SECURITY_HEADERS.items() if item[0] not in present
            ]
        await send(message)

    return send_with_headers
