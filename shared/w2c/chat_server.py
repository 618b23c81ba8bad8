"""A client of OpenAI's chat completions: patient with a busy server, silent about the key.

For services that ask a model elsewhere. What an answer means is theirs; this module sends a body
and returns the bytes of an answer. It needs httpx, which is in the extras of those services.
"""

import json
import logging
import os
import re
import threading
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any, Protocol

import httpx

from w2c.errors import ConfigError, DeadlineError, ModelError, RefusedError

_LOG = logging.getLogger("w2c.chat_server")
_ATTEMPTS = 4
_FIRST_PAUSE_S = 0.5
_LONGEST_PAUSE_S = 30.0
_RETRIED = {408, 409, 425, 429, 500, 502, 503, 504}
_MAX_REPLY_BYTES = 4_000_000
_MAX_STARTS = 200
"""Brackets at which JSON is looked for: each costs time, and prose has few before its JSON"""


class Patience(Protocol):
    """How long the caller of a request waits."""

    def check(self) -> None:
        """Raise DeadlineError when the time is over."""

    def remaining_s(self) -> float:
        """Return the time that is left [s], not below zero."""


class ChatServer:
    """One server. Thread-safe."""

    def __init__(
        self,
        url: str,
        key: str,
        *,
        flag: str,
        other_flags: str,
        pause: Callable[[float], None] | None = None,
    ) -> None:
        """Prepare a client; nothing is sent before the first request.

        Args:
            url: Base address, as in http://127.0.0.1:8080/v1.
            key: Sent as bearer token; empty: none is sent. Kept out of logs and errors.
            flag: Prefix of the service's flags for address and key, as in `--openai-`, for errors.
            other_flags: What else may be wrong when the server refuses a request, for errors.
            pause: Waits some seconds between attempts; tests pass their own.

        Raises:
            ConfigError: the address is none.
        """
        self.url = url
        self._flag = flag
        self._other_flags = other_flags
        self._closed = threading.Event()
        self._pause: Callable[[float], object] = pause or self._closed.wait
        check_address(url, f"{flag}url")
        headers = {"Authorization": f"Bearer {key}"} if key else {}
        self.client = httpx.Client(base_url=url.rstrip("/") + "/", headers=headers)

    def close(self) -> None:
        """Close the connections, and end the pauses. Idempotent."""
        self._closed.set()
        self.client.close()

    def complete(self, body: dict[str, Any], patience: Patience) -> bytes:
        """Return the answer to a chat, asked again after a pause where that may help.

        Raises:
            RefusedError: the server refuses the request itself.
            DeadlineError: the time is over.
            ModelError: the server does not answer.
        """
        reason, asked_for = "", 0.0
        for attempt in range(_ATTEMPTS):
            patience.check()
            if attempt:
                wait = _FIRST_PAUSE_S * 2 ** (attempt - 1)
                wait = min(max(wait, asked_for), _LONGEST_PAUSE_S, patience.remaining_s())
                _LOG.warning("server asked again", extra={"reason": reason, "pause_s": wait})
                self._pause(wait)
                patience.check()
            try:
                with self.client.stream(
                    "POST",
                    "chat/completions",
                    json=body,
                    timeout=max(patience.remaining_s(), 0.001),
                ) as response:
                    if response.status_code not in _RETRIED:
                        return self._read(response.status_code, _body(response, patience))
                    reason, asked_for = f"status {response.status_code}", _retry_after(response)
            except httpx.TimeoutException:
                raise DeadlineError(
                    f"{self.url} did not answer in time; check the server or its load"
                ) from None
            except httpx.HTTPError as error:
                reason, asked_for = f"{type(error).__name__}", 0.0
        raise ModelError(f"{self.url} failed {_ATTEMPTS} times, last: {reason}; is the server up?")

    def _read(self, status: int, content: bytes) -> bytes:
        if status in (401, 403):
            raise ModelError(
                f"{self.url} refuses the key (status {status}); check {self._flag}key-file"
            )
        if status != 200:
            # The body may repeat the request's headers: it is not quoted.
            raise RefusedError(
                f"{self.url} refuses the request (status {status}); check {self._other_flags}"
            )
        return content


def check_address(url: str, flag: str) -> None:
    """Raise ConfigError for what is no address of a web server."""
    try:
        address = httpx.URL(url)
    except httpx.InvalidURL as error:
        raise ConfigError(f"{flag} '{url}': {error}") from error
    if address.scheme not in ("http", "https") or not address.host:
        raise ConfigError(f"{flag} '{url}' must be like http://127.0.0.1:8080/v1")


def read_key(path: str) -> str:
    """Return the key of a server, from a file or the environment; empty where there is none.

    Raises:
        ConfigError: the file cannot be read, or holds no key. The message never holds the key.
    """
    if not path:
        key, source = os.environ.get("OPENAI_API_KEY", ""), "the variable OPENAI_API_KEY"
    else:
        source = f"the key file {path}"
        try:
            key = Path(path).read_text().strip()
        except (OSError, UnicodeDecodeError) as error:
            raise ConfigError(f"{source} cannot be read: {type(error).__name__}") from None
    if (path and not key) or not key.isascii() or not key.isprintable() or " " in key:
        raise ConfigError(f"{source} must hold one key and nothing else")
    return key


def extract_json(text: str) -> str:
    """Return the first JSON object or array in a text; the text itself where there is none."""
    decoder = json.JSONDecoder()
    for match in islice(re.finditer(r"[{\[]", text), _MAX_STARTS):
        try:
            _, end = decoder.raw_decode(text, match.start())
        except (ValueError, RecursionError):
            continue
        return text[match.start() : end]
    return text.strip()


def _body(response: httpx.Response, patience: Patience) -> bytes:
    """Return a body that comes in time and is not too long, however slowly it drips."""
    body = bytearray()
    for part in response.iter_bytes():
        patience.check()
        body += part
        if len(body) > _MAX_REPLY_BYTES:
            raise ModelError(f"the server sent more than {_MAX_REPLY_BYTES} bytes")
    return bytes(body)


def _retry_after(response: httpx.Response) -> float:
    """Return how long a busy server asks to wait [s]; 0 where it does not say so in seconds."""
    text = response.headers.get("Retry-After", "")
    return float(text) if text.isascii() and text.isdigit() and len(text) < 6 else 0.0
