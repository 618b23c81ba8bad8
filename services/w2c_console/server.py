"""The web server, on a thread of its own: signals stay with the service."""

import socket
import threading

import uvicorn
from starlette.types import ASGIApp

from w2c.errors import ConfigError

MAX_WEBSOCKET_MESSAGE = 4096
"""The page sends wishes of a few bytes [bytes]"""


def bind(host: str, port: int) -> socket.socket:
    """Return a listening socket. Raises ConfigError for an address that cannot be had."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
    except socket.gaierror as error:
        raise ConfigError(f"--host {host} is no address of this machine: {error}") from error
    listener = socket.socket(family, kind, protocol)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind(address)
        listener.listen(128)
    except OSError as error:
        listener.close()
        raise ConfigError(
            f"cannot listen at port {port} of {host}: {error.strerror}. "
            "Is another console running? Choose another --port"
        ) from error
    return listener


class WebServer:
    """Serves an application at a socket until it is closed."""

    def __init__(self, app: ASGIApp, listener: socket.socket) -> None:
        self._listener = listener
        self._server = uvicorn.Server(
            uvicorn.Config(
                app,
                ws="websockets-sansio",
                ws_max_size=MAX_WEBSOCKET_MESSAGE,
                ws_per_message_deflate=False,  # a JPEG does not get smaller
                lifespan="off",
                log_config=None,
                log_level="warning",  # a page that comes or goes is no event of the log
                access_log=False,
                server_header=False,
                timeout_graceful_shutdown=1,
            )
        )
        self._thread = threading.Thread(
            target=self._server.run, kwargs={"sockets": [listener]}, name="web", daemon=True
        )

    def start(self) -> None:
        """Begin to serve. Pages that came before wait in the socket's queue."""
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether it serves."""
        return self._thread.is_alive()

    def close(self) -> None:
        """End connections, free the port."""
        self._server.should_exit = True
        if self._thread.is_alive():
            self._thread.join(timeout=3.0)
        self._listener.close()
