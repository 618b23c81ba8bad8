"""`w2c dialogue`: the service, and its verbs `batch` (modules on lines of JSON) and `corpus`."""

import sys
from collections.abc import Callable

from w2c import service
from w2c.bus import Bus
from w2c.clock import Clock
from w2c_dialogue.config import DialogueConfig


def load_node() -> Callable[[DialogueConfig, Bus, Clock], service.Node]:
    """Import the node."""
    from w2c_dialogue.node import DialogueNode

    return DialogueNode


def main(arguments: list[str] | None = None) -> int:
    """Run the verb that the first argument names, or the service."""
    argv = sys.argv[1:] if arguments is None else arguments
    if argv[:1] == ["corpus"]:
        from w2c_dialogue.corpus.commands import corpus

        return corpus(argv[1:])
    if argv[:1] == ["batch"]:
        from w2c_dialogue.batch.commands import batch

        return batch(argv[1:])
    return service.main("dialogue", DialogueConfig, load_node, argv, extra="dialogue")


if __name__ == "__main__":
    raise SystemExit(main())
