"""The verbs `record`, which talks to the running recorder, and `recording`, which reads files."""

import json
import sys
from collections.abc import Callable

from w2c import topics
from w2c.bus import Bus
from w2c.config import parse
from w2c.errors import ConfigError
from w2c.extras import needs_extra
from w2c.messages import Empty, MarkRequest, RecorderStatus, RecordRequest
from w2c.system import Connection, service_config
from w2c_recorder.flags import make_parser
from w2c_recorder.report import Report, spare, write_file

MAX_MARK = 1000
WRITTEN = ("json", "html", "out")
"""Flags of `w2c recording` that name a file to be written"""


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
    """Look into a recording. Status 1 where `check` found a limit exceeded."""
    argv = sys.argv[1:] if arguments is None else arguments
    options = make_parser().parse_args(argv)
    with needs_extra("recorder"):
        from w2c_recorder import actions
        from w2c_recorder.series import files_of

        if options.file.exists():
            written = [getattr(options, name, None) for name in WRITTEN]
            spare(files_of(options.file).values(), *written)
        report: Report = getattr(actions, options.action)(options)
    for line in report.lines:
        print(line)
    if getattr(options, "json", None) is not None:
        write_file(options.json, (json.dumps(report.values, indent=1) + "\n").encode())
    return report.status
