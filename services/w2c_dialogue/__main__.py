"""`w2c dialogue`: the service; `w2c dialogue corpus`: write the corpus of the embedded model."""

import sys

from w2c_dialogue.corpus.commands import corpus


def main(arguments: list[str] | None = None) -> int:
    """Run the command of the first argument, or the service."""
    argv = sys.argv[1:] if arguments is None else arguments
    if argv[:1] == ["corpus"]:
        return corpus(argv[1:])
    return 2


if __name__ == "__main__":
    raise SystemExit(main())
