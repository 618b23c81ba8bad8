"""A GGUF file in memory: weights, vocabulary and metadata, through llama.cpp's own interface.

The high-level `llama_cpp.Llama` is not used: it keeps one sequence a context, copies whole score
arrays, and lets an invalid grammar end the process.
"""

import ctypes
import functools
import logging
from collections.abc import Sequence
from pathlib import Path

import llama_cpp

from w2c.errors import ConfigError, ModelError

_LOG = logging.getLogger("w2c.llm.llama")
_LEVELS = {3: logging.INFO, 4: logging.ERROR}
"""ggml's warning and error; the rest is chatter"""
_PIECE_BYTES = 4096
_META_BYTES = 200_000


@llama_cpp.llama_log_callback  # type: ignore[untyped-decorator]
def _forward_log(level: int, text: bytes, _: object) -> None:
    """Turn lines of llama.cpp into log records, one level lower than it thinks."""
    line = text.decode("utf-8", "replace").strip()
    if line and line != ".":
        _LOG.log(_LEVELS.get(level, logging.DEBUG), "%s", line)


def is_built_for_amx() -> bool:
    """Tell whether llama.cpp would multiply with AMX here.

    Such builds end the process with a segmentation fault: compilers drop the tiles' configuration,
    which ggml writes to the stack (llama.cpp issue 20824; seen with GCC 12). `deploy/setup.sh`
    builds without; a wheel from elsewhere may not be.
    """
    return b"AMX_INT8 = 1" in llama_cpp.llama_print_system_info()


class LlamaModel:
    """Owns the weights of one model. Not thread-safe: one thread uses it."""

    def __init__(self, path: Path, gpu_layers: int = 0) -> None:
        """Load a file. `gpu_layers` -1 = all of them.

        Raises:
            ConfigError: there is no such file.
            ModelError: llama.cpp cannot load it.
        """
        if not path.is_file():
            raise ConfigError(f"no language model at {path}; give a GGUF file with --model")
        llama_cpp.llama_log_set(_forward_log, ctypes.c_void_p(0))
        llama_cpp.llama_backend_init()
        parameters = llama_cpp.llama_model_default_params()
        parameters.n_gpu_layers = 0x7FFFFFFF if gpu_layers < 0 else gpu_layers
        # In its own buffers for AMX the first product would end the process.
        parameters.use_extra_bufts = not is_built_for_amx()
        self.handle = llama_cpp.llama_model_load_from_file(str(path).encode(), parameters)
        if not self.handle:
            raise ModelError(f"llama.cpp cannot load {path}; is it a GGUF file, and whole?")
        self.path = path
        self.vocabulary = llama_cpp.llama_model_get_vocab(self.handle)
        self.vocabulary_size: int = llama_cpp.llama_vocab_n_tokens(self.vocabulary)
        self.trained_context: int = llama_cpp.llama_model_n_ctx_train(self.handle)
        self._piece = ctypes.create_string_buffer(_PIECE_BYTES)

    def close(self) -> None:
        """Free the weights. Idempotent."""
        if self.handle:
            llama_cpp.llama_model_free(self.handle)
            self.handle = None

    def metadata(self, key: str) -> str | None:
        """Return a metadata value as text; None where the file has none."""
        buffer = ctypes.create_string_buffer(_META_BYTES)
        length = llama_cpp.llama_model_meta_val_str(
            self.handle, key.encode(), buffer, ctypes.sizeof(buffer)
        )
        return None if length < 0 else buffer.value.decode("utf-8", "replace")

    @property
    def chat_template(self) -> str | None:
        """The Jinja template of the file."""
        template = llama_cpp.llama_model_chat_template(self.handle, None)
        return None if template is None else template.decode("utf-8", "replace")

    def tokenize(self, text: str, *, special: bool) -> list[int]:
        """Return the tokens of a text; `special` reads <|end|> and its like as control tokens.

        No token is added at the ends: the chat template writes what the model wants there.
        """
        data = text.encode()
        capacity = len(data) + 8
        tokens = (llama_cpp.llama_token * capacity)()
        count = llama_cpp.llama_tokenize(
            self.vocabulary, data, len(data), tokens, capacity, False, special
        )
        if count < 0:
            raise ModelError(f"llama.cpp cannot tokenize a text of {len(data)} bytes ({count})")
        return list(tokens[:count])

    def detokenize(self, tokens: Sequence[int]) -> str:
        """Return the text of tokens; control tokens have none."""
        return b"".join(self.piece(token, special=False) for token in tokens).decode(
            "utf-8", "replace"
        )

    def piece(self, token: int, *, special: bool) -> bytes:
        """Return the bytes of one token."""
        length = llama_cpp.llama_token_to_piece(
            self.vocabulary, token, self._piece, _PIECE_BYTES, 0, special
        )
        if length < 0:
            raise ModelError(f"token {token} is longer than {_PIECE_BYTES} bytes")
        return bytes(self._piece.raw[:length])

    def is_control(self, token: int) -> bool:
        """Return whether a token is a mark, such as <|end|>, and not a piece of text."""
        attributes = llama_cpp.llama_vocab_get_attr(self.vocabulary, token)
        if attributes & llama_cpp.LLAMA_TOKEN_ATTR_CONTROL:
            return True
        # Some files declare their marks as user-defined.
        text = self.piece(token, special=True)
        user_defined = bool(attributes & llama_cpp.LLAMA_TOKEN_ATTR_USER_DEFINED)
        return user_defined and text.startswith(b"<") and text.endswith(b">")

    def is_end(self, token: int) -> bool:
        """Return whether a token ends the model's turn."""
        return bool(llama_cpp.llama_vocab_is_eog(self.vocabulary, token))

    @property
    def end_of_turn(self) -> int:
        """The token that the model writes after its answer."""
        token = int(llama_cpp.llama_vocab_eot(self.vocabulary))
        return token if token >= 0 else int(llama_cpp.llama_vocab_eos(self.vocabulary))

    def token_text(self, token: int) -> str:
        """Return how a special token is written; empty for "no such token" (-1)."""
        return "" if token < 0 else self.piece(token, special=True).decode("utf-8", "replace")

    @property
    def begin_text(self) -> str:
        """How the token at the beginning of a text is written."""
        return self.token_text(int(llama_cpp.llama_vocab_bos(self.vocabulary)))

    @functools.cached_property
    def control_texts(self) -> frozenset[str]:
        """How control tokens are written: what a stranger's text must not hold."""
        return frozenset(
            self.token_text(token)
            for token in range(self.vocabulary_size)
            if self.is_control(token)
        ) - {""}
