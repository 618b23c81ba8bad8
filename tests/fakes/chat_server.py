"""A server with OpenAI's chat completions that replies what a test prepared."""

import json
import threading
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Any


class ChatServer:
    """Replies in order; the last reply is repeated. Remembers requests and their keys."""

    def __init__(self, *replies: tuple[int, Any] | tuple[int, Any, dict[str, str]]) -> None:
        """Prepare (status, body[, headers]) replies; a body that is bytes is sent as it is."""
        self._replies = list(replies)
        self._lock = threading.Lock()
        self.requests: list[dict[str, Any]] = []
        self.authorizations: list[str | None] = []
        fake = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                length = int(self.headers["Content-Length"])
                fake._remember(json.loads(self.rfile.read(length)), self.headers["Authorization"])
                status, body, *headers = fake._next()
                payload = body if isinstance(body, bytes) else json.dumps(body).encode()
                self.send_response(status)
                self.send_header("Content-Length", str(len(payload)))
                for name, value in (headers[0] if headers else {}).items():
                    self.send_header(name, value)
                self.end_headers()
                with suppress(ConnectionError):  # a client that has read enough
                    self.wfile.write(payload)

            def log_message(self, format: str, *args: object) -> None:
                """Say nothing."""

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=(0.02,), daemon=True
        )

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self._server.server_address[1]}/v1"

    def __enter__(self) -> "ChatServer":
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def _remember(self, request: dict[str, Any], authorization: str | None) -> None:
        with self._lock:
            self.requests.append(request)
            self.authorizations.append(authorization)

    def _next(self) -> tuple[Any, ...]:
        with self._lock:
            return self._replies.pop(0) if len(self._replies) > 1 else self._replies[0]


def completion(content: str, **extra: Any) -> dict[str, Any]:
    """Return the body of a chat completion."""
    choice = {"index": 0, "finish_reason": "stop", "message": {"content": content}, **extra}
    usage = {"prompt_tokens": 20, "completion_tokens": 5, "total_tokens": 25}
    return {"object": "chat.completion", "choices": [choice], "usage": usage}
