"""`w2c llm`: serve a language model."""

from collections.abc import Callable

from w2c import service
from w2c.bus import Bus
from w2c.clock import Clock
from w2c_llm.config import LlmConfig


def load_node() -> Callable[[LlmConfig, Bus, Clock], service.Node]:
    """Import the node; the libraries of the model come with the backend that the flags name."""
    from w2c_llm.node import LlmNode

    return LlmNode


def main(arguments: list[str] | None = None) -> int:
    """Run the service. Returns the exit status."""
    return service.main("llm", LlmConfig, load_node, arguments, extra="llm")


if __name__ == "__main__":
    raise SystemExit(main())
