"""`w2c llm`: serve a language model."""

from collections.abc import Callable

from w2c import service
from w2c.bus import Bus
from w2c.clock import Clock
from w2c_llm.config import LlmConfig


def load_node() -> Callable[[LlmConfig, Bus, Clock], service.Node]:
    """Import the node, and with it the model's libraries."""
    import llama_cpp  # noqa: F401 - a missing extra shows here, with the command that installs it
    import llguidance  # noqa: F401

    from w2c_llm.node import LlmNode

    return LlmNode


def main(arguments: list[str] | None = None) -> int:
    """Run the service. Returns the exit status."""
    return service.main("llm", LlmConfig, load_node, arguments, extra="llm")


if __name__ == "__main__":
    raise SystemExit(main())
