"""`w2c VERB`: services register verbs in the entry-point group `w2c.commands`."""

import os
import select
import sys
from collections.abc import Callable
from difflib import get_close_matches
from importlib.metadata import EntryPoint, entry_points

from w2c import __version__
from w2c.config import fail
from w2c.errors import MissingExtraError, W2CError

GROUPS = {
    "processes": ("up", "down", "status", "doctor", "demo", "router"),
    "operator": ("say", "confirm", "place", "release", "stop", "resume"),
    "look": ("ground", "lift", "cloud"),
    "recordings": ("record", "recording", "replay"),
    "measure and train": ("bench", "evaluate", "benchmark", "train", "scenes"),
    "one service": (
        "robot", "camera", "controller", "perception", "grounding", "llm", "dialogue", "recorder",
        "console", "recorded-robot",
    ),
}  # fmt: skip

SUBVERBS = ("bench", "evaluate", "train")
"""`w2c bench NAME`: the names are entry points of the group `w2c.bench`."""


def _usage(verbs: dict[str, EntryPoint]) -> str:
    lines = [
        f"w2c {__version__}: tell a humanoid, in plain words, where to put its hands and feet",
        "",
    ]
    lines.append("usage: w2c VERB [flags]      w2c VERB --help")
    for title, names in GROUPS.items():
        present = [name for name in names if name in verbs or name in SUBVERBS]
        lines.append(f"  {title + ':':<20}{' '.join(present)}")
    return "\n".join(lines)


def _dispatch_group(group: str, verb: str, arguments: list[str]) -> int:
    """Run `w2c train NAME` or `w2c bench NAME`: NAME is an entry point of a service."""
    names = {point.name: point for point in entry_points(group=group)}
    if not arguments or arguments[0] not in names:
        raise_for = arguments[0] if arguments else "nothing"
        sys.stderr.write(f"w2c {verb}: {raise_for}; choose one of: {', '.join(sorted(names))}\n")
        return 2
    return int(names[arguments[0]].load()(arguments[1:]))


def _run_verb(verb: str, rest: list[str], verbs: dict[str, EntryPoint]) -> int:
    """Load and run one verb."""
    if verb in SUBVERBS:
        return _dispatch_group(f"w2c.{verb}", verb, rest)
    if verb not in verbs:
        near = get_close_matches(verb, verbs, n=1)
        hint = f"; did you mean '{near[0]}'?" if near else ""
        sys.stderr.write(f"w2c: no verb '{verb}'{hint}\n{_usage(verbs)}\n")
        return 2
    command: Callable[[list[str]], int] = verbs[verb].load()
    return command(rest)


def main(arguments: list[str] | None = None) -> int:
    """Run a verb. Exit status: 0 done, 1 failed, 2 usage or missing dependency."""
    argv = sys.argv[1:] if arguments is None else arguments
    verbs = {point.name: point for point in entry_points(group="w2c.commands")}
    if not argv or argv[0] in ("-h", "--help", "help"):
        print(_usage(verbs))
        return 0 if argv else 2
    if argv[0] == "--version":
        print(__version__)
        return 0
    try:
        return _run_while_read(argv[0], argv[1:], verbs)
    except ModuleNotFoundError as error:
        if (error.name or "").startswith("w2c"):
            raise
        return fail(MissingExtraError(error.name or "?", "all"), f"w2c {argv[0]}")
    except W2CError as error:
        return fail(error, f"w2c {argv[0]}")
    except KeyboardInterrupt:
        return 130


def _run_while_read(verb: str, rest: list[str], verbs: dict[str, EntryPoint]) -> int:
    """Run a verb. It fails quietly where who reads its output goes away, as `head` does."""
    try:
        status = _run_verb(verb, rest, verbs)
        sys.stdout.flush()
    except BrokenPipeError:
        if not _nobody_reads():
            raise
        return 1
    return status


def _nobody_reads() -> bool:
    """Tell whether it was the output that broke; then drop what is left of it."""
    try:
        output = sys.stdout.fileno()
    except (OSError, ValueError):  # it is no file of the system
        return False
    watch = select.poll()
    watch.register(output, 0)
    if not watch.poll(0):
        return False
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, output)
    os.close(nowhere)
    return True


if __name__ == "__main__":
    raise SystemExit(main())
