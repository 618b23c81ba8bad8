"""A vision-language model behind any OpenAI-compatible server: llama-server, vLLM, or a cloud."""

import base64
import io
from collections.abc import Callable
from typing import Any

import msgspec
from PIL import Image

from w2c.chat_server import ChatServer
from w2c.clock import Clock, RealClock
from w2c.errors import DeadlineError, ModelError
from w2c_grounding.family import RgbImage
from w2c_grounding.pointer.options import PointerOptions
from w2c_grounding.pointer.talker import Shown, Turn

_JPEG_QUALITY = 90
"""Points move by less than a pixel against a lossless picture, which is ten times as long"""


class _Content(msgspec.Struct):
    content: str | None = None


class _Choice(msgspec.Struct):
    message: _Content


class _Reply(msgspec.Struct):
    """The fields of a chat completion that are used; the rest is ignored."""

    choices: list[_Choice]


class _Deadline:
    """Until when one question may take."""

    def __init__(self, clock: Clock, seconds: float) -> None:
        self._clock = clock
        self._seconds = seconds
        self._end_ns = clock.now_ns() + int(seconds * 1e9)

    def remaining_s(self) -> float:
        """Return the time that is left [s], not below zero."""
        return max(0.0, (self._end_ns - self._clock.now_ns()) * 1e-9)

    def check(self) -> None:
        """Raise DeadlineError when the time is over."""
        if self.remaining_s() <= 0.0:
            raise DeadlineError(
                f"the pointing model gave no answer within {self._seconds:g} s; "
                "use a faster one, or a longer --pointer.deadline"
            )


class ServerTalker:
    """A client of one server. Thread-safe."""

    def __init__(
        self,
        options: PointerOptions,
        model: str,
        key: str,
        *,
        clock: Clock | None = None,
        pause: Callable[[float], None] | None = None,
    ) -> None:
        """Prepare; nothing is sent before the first question. Raises ConfigError.

        Args:
            options: The server and what it understands.
            model: Name of the model there.
            key: Kept out of logs and errors; empty: none is sent.
            clock: For the deadline.
            pause: Waits some seconds between attempts; tests pass their own.
        """
        self._options = options
        self._model = model
        self._clock = clock or RealClock()
        self._server = ChatServer(
            options.url,
            key,
            flag="--pointer.",
            other_flags="--model, and --pointer.url, .sampling and .token-limit",
            pause=pause,
        )

    @property
    def at_once(self) -> int:
        """How many threads may ask at once."""
        return self._options.concurrency

    def show(self, image: RgbImage) -> Shown:
        """Return the picture as a data URL of a JPEG, shrunk where it is larger than wanted."""
        picture = shrunk(image, self._options.longest_side)
        buffer = io.BytesIO()
        picture.save(buffer, format="JPEG", quality=_JPEG_QUALITY)
        data = base64.b64encode(buffer.getvalue()).decode("ascii")
        return Shown(picture.width, picture.height, f"data:image/jpeg;base64,{data}")

    def ask(self, shown: Shown, turns: list[Turn]) -> str:
        """Return the answer to the last turn."""
        messages: list[dict[str, Any]] = [
            {"role": turn.role, "content": turn.text} for turn in turns
        ]
        messages[0]["content"] = [
            {"type": "image_url", "image_url": {"url": shown.picture}},
            {"type": "text", "text": turns[0].text},
        ]
        body: dict[str, Any] = {
            "model": self._model,
            "messages": messages,
            self._options.token_limit: self._options.max_tokens,
        }
        if self._options.sampling:
            body["temperature"] = 0.0
        content = self._server.complete(body, _Deadline(self._clock, self._options.deadline))
        try:
            reply = msgspec.json.decode(content, type=_Reply)
        except msgspec.MsgspecError as error:
            raise ModelError(f"{self._server.url} sent no chat completion: {error}") from error
        if not reply.choices:
            raise ModelError(f"{self._server.url} sent a chat completion without choices")
        return reply.choices[0].message.content or ""

    def warm_up(self) -> None:
        """Do nothing: a question would cost money, and the server may come later."""

    def close(self) -> None:
        """Close the connections. Idempotent."""
        self._server.close()


def shrunk(image: RgbImage, longest_side: int) -> Image.Image:
    """Return the picture with its longest side bounded [px], its aspect kept."""
    picture = Image.fromarray(image)
    scale = longest_side / max(picture.size)
    if scale >= 1.0:
        return picture
    size = (max(1, round(picture.width * scale)), max(1, round(picture.height * scale)))
    return picture.resize(size, Image.Resampling.BILINEAR, reducing_gap=2.0)
