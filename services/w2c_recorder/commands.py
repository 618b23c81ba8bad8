"""The verbs `record`, which talks to the running recorder, and `recording`, which reads files."""

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from w2c import topics
from w2c.bus import Bus
from w2c.config import parse
from w2c.errors import ConfigError
from w2c.extras import needs_extra
from w2c.messages import Empty, MarkRequest, RecorderStatus, RecordRequest
from w2c.system import Connection, service_config

MAX_MARK = 1000


class RecordConfig(Connection, frozen=True, kw_only=True):
    """Talk to the recorder: `w2c record start|stop|status`, `w2c record mark "TEXT"`."""

    path: str = ""
    """Where `start` writes, on the recorder's machine; empty = into its run directory."""


def record(arguments: list[str] | None = None) -> int:
    """Start, stop, ask after or annotate the recording. Status 1 where it stopped by itself."""
    ask, flags = _record_action(list(sys.argv[1:] if arguments is None else arguments))
    config = parse(RecordConfig, flags, program="w2c record")
    service = service_config(config)
    from w2c.bus.zenoh_bus import connect

    with connect(service, "operator", [service.router]) as bus:
        status = ask(bus, config)
    print(describe_status(status))
    return 1 if status.error else 0


def _record_action(
    argv: list[str],
) -> tuple[Callable[[Bus, RecordConfig], RecorderStatus], list[str]]:
    """Return what to ask the recorder, and the flags that are left. Raises ConfigError."""
    action, flags = (argv[0], argv[1:]) if argv else ("", [])
    if action == "mark" and flags and not flags[0].startswith("--"):
        text, flags = flags[0], flags[1:]
        if not 1 <= len(text) <= MAX_MARK:
            raise ConfigError(f"a mark has 1 to {MAX_MARK} characters, this one {len(text)}")
        return lambda bus, _: bus.call(topics.RECORD_MARK, MarkRequest(text=text)).message, flags
    actions: dict[str, Callable[[Bus, RecordConfig], RecorderStatus]] = {
        "start": lambda bus, config: (
            bus.call(topics.RECORD_START, RecordRequest(path=config.path)).message
        ),
        "stop": lambda bus, _: bus.call(topics.RECORD_STOP, Empty()).message,
        "status": lambda bus, _: bus.call(topics.RECORD_STATUS, Empty()).message,
    }
    if action in actions:
        return actions[action], flags
    if action in ("--help", "-h"):
        return actions["status"], argv
    raise ConfigError(
        f"'{' '.join(argv)}': choose one of: start [--path FILE.mcap], stop, status, mark \"TEXT\""
    )


def describe_status(status: RecorderStatus) -> str:
    """Return the state of the recorder for a person."""
    state = "recording into" if status.recording else "not recording; last file:"
    lines = [f"{state} {status.path or 'none'}"]
    if status.path:
        lines.append(f"{status.messages} messages, {status.bytes / 1e6:.1f} MB")
    lines += [f"lost {count} of {key}" for key, count in sorted(status.lost.items())]
    if status.error:
        lines.append(f"stopped by itself: {status.error}")
    return "\n".join(lines)


def recording(arguments: list[str] | None = None) -> int:
    """Show what is in a recording."""
    argv = sys.argv[1:] if arguments is None else arguments
    parser = argparse.ArgumentParser(prog="w2c recording", description="Look into a recording.")
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, purpose in (
        ("info", "channels, counts, rates, gaps, duration, versions"),
        ("timeline", "the conversation: turns, goals, calls that failed, warnings"),
    ):
        action = actions.add_parser(name, help=purpose, description=purpose)
        action.add_argument("file", type=Path, help="an MCAP file, closed or not")
        action.add_argument("--json", type=Path, help="write the same as JSON into this file")
    options = parser.parse_args(argv)
    show = _show_info if options.action == "info" else _show_timeline
    with needs_extra("recorder"):
        values = show(options.file)
    if options.json is not None:
        _write_json(options.json, values)
    return 0


def _show_info(path: Path) -> dict[str, Any]:
    """Print the overview of a recording and return it as plain values."""
    from w2c_recorder.overview import overview_of
    from w2c_recorder.reading import Recording

    overview = overview_of(Recording(path))
    start = datetime.fromtimestamp(overview.start_ns * 1e-9, UTC)
    print(f"{overview.path}: {overview.size_bytes / 1e6:.2f} MB, {overview.messages} messages")
    print(f"from {start:%Y-%m-%d %H:%M:%S} UTC, {overview.duration_s:.1f} s")
    if overview.recovered:
        print(f"recovered after a crash: {overview.recovered}")
    if overview.damage:
        print(f"DAMAGED: {overview.damage}")
    for name, value in overview.session.items():
        print(f"  {name:<20} {value}")
    width = max((len(channel.key) for channel in overview.channels), default=3)
    print(f"{'key':<{width}}  {'message':<16} {'count':>8} {'Hz':>8} {'gap [ms]':>9} {'lost':>6}")
    for channel in overview.channels:
        malformed = f"  {channel.malformed} MALFORMED" if channel.malformed else ""
        print(
            f"{channel.key:<{width}}  {channel.message or 'unknown':<16} {channel.count:>8} "
            f"{channel.rate_hz:>8.1f} {channel.longest_gap_ns * 1e-6:>9.1f} {channel.lost:>6}"
            f"{malformed}"
        )
    channels = [{**asdict(channel), "rate_hz": channel.rate_hz} for channel in overview.channels]
    return {**asdict(overview), "messages": overview.messages, "channels": channels}


def _show_timeline(path: Path) -> dict[str, Any]:
    """Print the story of a recording and return it as plain values."""
    from w2c_recorder.reading import Recording
    from w2c_recorder.timeline import timeline_of

    source = Recording(path)
    entries = []
    for entry in timeline_of(source):
        minutes, seconds = divmod(entry.seconds, 60)
        print(f"{minutes:3.0f}:{seconds:06.3f}  {entry.actor:<14} {entry.text}")
        entries.append(asdict(entry))
    if not source.damage.complete:
        print(f"the recording was not closed: {source.damage.reason}")
    return {"path": str(path), "start_ns": source.start_ns, "entries": entries}


def _write_json(path: Path, values: dict[str, Any]) -> None:
    try:
        path.write_text(json.dumps(values, indent=1) + "\n")
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from error
