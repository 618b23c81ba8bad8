"""Flags of the llm service."""

from pathlib import Path
from typing import Annotated, Literal

import msgspec

from w2c.config import ServiceConfig

EMBEDDED_MODEL = Path(__file__).parent / "embedded" / "w2c-language.gguf"


class LlmConfig(ServiceConfig, frozen=True, kw_only=True):
    """What the llm service needs: a model, and bounds."""

    backend: Literal["llama_cpp", "openai", "replay"] = "llama_cpp"
    """llama_cpp: a GGUF file on this machine. openai: any server with OpenAI's chat completions.
    replay: the answers of a recording."""
    model: str = ""
    """Path of a GGUF file, the model's name at the server, or path of a recording (MCAP); empty:
    the embedded model."""
    context: Annotated[int, msgspec.Meta(ge=256, le=1_000_000)] = 4096
    """Tokens that fit in memory: the request and all reused prefixes together."""
    threads: Annotated[int, msgspec.Meta(ge=0, le=256)] = 0
    """CPU threads of the model; 0: one for the embedded model, else half of the cores. They wait
    actively for each other: more threads than free cores make every call many times slower."""
    gpu_layers: Annotated[int, msgspec.Meta(ge=-1)] = 0
    """Layers on the GPU, where llama.cpp was built for one; -1: all."""
    constraint: Literal["llguidance", "gbnf"] = "llguidance"
    """llama_cpp: what keeps answers within their schema. gbnf: llama.cpp's own grammars, a hundred
    times slower with a large vocabulary, for machines that llguidance has no wheel for."""
    queue: Annotated[int, msgspec.Meta(ge=1, le=64)] = 8
    """Requests that may wait; more are refused."""
    deadline: Annotated[float, msgspec.Meta(gt=0, le=600)] = 55.0
    """Longest time of a request, waiting included [s]; a request may ask for less."""
    openai_url: str = "https://api.openai.com/v1"
    """Base address of the server."""
    openai_key_file: str = ""
    """File with the key; empty: the environment variable OPENAI_API_KEY; else none is sent."""
    openai_schema: Literal["json_schema", "json_object", "gbnf", "none"] = "json_schema"
    """How the server is asked for JSON: with the schema, only for some JSON, with a grammar (which
    llama-server takes), or in words alone."""
    openai_sampling: bool = True
    """Send temperature and seed; off for models that refuse them."""
    openai_token_limit: Literal["max_tokens", "max_completion_tokens"] = "max_tokens"  # noqa: S105
    """Name of the limit in the server's interface."""
    openai_logprobs: bool = False
    """The server returns the likelihood of the first tokens: choices get real probabilities."""
    openai_concurrency: Annotated[int, msgspec.Meta(ge=1, le=64)] = 4
    """Requests at the server at once."""

    def model_files(self) -> Path | None:
        """Return the file of the model; None where it is at a server."""
        if self.backend == "openai":
            return None
        return Path(self.model) if self.model else EMBEDDED_MODEL
