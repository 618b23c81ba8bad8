"""Flags of `w2c recording`."""

import argparse
import re
from pathlib import Path

_TIME = re.compile(r"(?:(\d+):)?(\d+(?:\.\d+)?)")


def seconds(text: str) -> float:
    """Return a time of the timeline [s], written as 75.2 or 1:15.2."""
    match = _TIME.fullmatch(text)
    if match is None:
        raise argparse.ArgumentTypeError(f"'{text}' is no time; write 75.2 or 1:15.2")
    return 60.0 * int(match[1] or 0) + float(match[2])


def make_parser() -> argparse.ArgumentParser:
    """Return the parser; its help shows the flags of every action."""
    parser = argparse.ArgumentParser(
        prog="w2c recording",
        description="Look into a recording.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    made = [
        _info(actions),
        _timeline(actions),
        _check(actions),
        _frame(actions),
        _why(actions),
        _export(actions),
    ]
    parser.epilog = "\n".join(action.format_usage().rstrip() for action in made)
    return parser


_Actions = argparse._SubParsersAction  # there is no public name for it


def _add(
    actions: "_Actions[argparse.ArgumentParser]", name: str, purpose: str
) -> argparse.ArgumentParser:
    action: argparse.ArgumentParser = actions.add_parser(name, help=purpose, description=purpose)
    action.add_argument("file", type=Path, help="an MCAP file, closed or not")
    return action


def _add_json(action: argparse.ArgumentParser) -> None:
    action.add_argument("--json", type=Path, metavar="FILE", help="write the same as JSON")


def _add_time(action: argparse.ArgumentParser) -> None:
    action.add_argument(
        "--at", type=seconds, required=True, metavar="T", help="as in the timeline: 75.2 or 1:15.2"
    )


def _info(actions: "_Actions[argparse.ArgumentParser]") -> argparse.ArgumentParser:
    action = _add(actions, "info", "channels, counts, rates, gaps, duration, versions")
    _add_json(action)
    return action


def _timeline(actions: "_Actions[argparse.ArgumentParser]") -> argparse.ArgumentParser:
    action = _add(actions, "timeline", "the conversation: turns, calls, goals, warnings")
    _add_json(action)
    action.add_argument(
        "--html", type=Path, metavar="FILE", help="write it as one page with the pictures"
    )
    return action


def _check(actions: "_Actions[argparse.ArgumentParser]") -> argparse.ArgumentParser:
    action = _add(
        actions, "check", "rates, ages, jitter, losses, deadlines; status 1 beyond a limit"
    )
    action.add_argument("--budget", type=Path, metavar="FILE", help="limits, a TOML file")
    action.add_argument("--all", action="store_true", help="show what is within its limit, too")
    _add_json(action)
    return action


def _frame(actions: "_Actions[argparse.ArgumentParser]") -> argparse.ArgumentParser:
    action = _add(actions, "frame", "the picture with target, boxes and heat drawn on it")
    _add_time(action)
    action.add_argument(
        "--newest",
        action="store_true",
        help="the newest picture instead of the one that the target was chosen in",
    )
    action.add_argument(
        "--out", type=Path, default=Path("frame.png"), metavar="FILE", help=".png or .jpg"
    )
    return action


def _why(actions: "_Actions[argparse.ArgumentParser]") -> argparse.ArgumentParser:
    action = _add(actions, "why", "from a joint command back to the words it came from")
    _add_time(action)
    _add_json(action)
    return action


def _export(actions: "_Actions[argparse.ArgumentParser]") -> argparse.ArgumentParser:
    action = _add(actions, "export", "write it for other programs")
    action.add_argument(
        "--to",
        choices=("csv", "parquet", "dataset", "mp4", "foxglove", "rerun"),
        required=True,
        help="csv, parquet: one stream as a table; dataset: the conversations, for training; "
        "mp4: the camera's pictures as a film; foxglove: the recording with channels that "
        "Foxglove and Rerun show, where it has none; rerun: a file in Rerun's own columns",
    )
    action.add_argument("--channel", default="", metavar="KIND/SERVICE/NAME", help="of a table")
    action.add_argument("--out", type=Path, metavar="PATH", help="file, or directory of a dataset")
    action.add_argument("--start", type=seconds, default=0.0, metavar="T", help="of a table")
    action.add_argument("--end", type=seconds, metavar="T", help="of a table")
    return action
