"""Logging: events for people on the terminal, JSON lines in the run directory."""

import json
import logging
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from w2c import topics
from w2c.bus import Bus
from w2c.errors import BusError, ConfigError, MessageError
from w2c.messages import LogRecord

LEVELS = {
    "debug": logging.DEBUG,
    "info": logging.INFO,
    "warning": logging.WARNING,
    "error": logging.ERROR,
}
_STANDARD = set(vars(logging.makeLogRecord({}))) | {"message", "asctime", "taskName"}


def extra_fields(record: logging.LogRecord) -> dict[str, str]:
    """Return what the caller passed as `extra`."""
    return {key: str(value) for key, value in vars(record).items() if key not in _STANDARD}


class JsonFormatter(logging.Formatter):
    """One JSON object a line."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
        entry: dict[str, object] = {
            "time": record.created,
            "level": record.levelname.lower(),
            "logger": record.name,
            "text": record.getMessage(),
            **extra_fields(record),
        }
        if record.exc_info:
            entry["exception"] = self.formatException(record.exc_info)
        return json.dumps(entry)


def configure_logs(service: str, level: str, run_directory: str) -> None:
    """Send the log to stderr, and to `<run_directory>/<service>.jsonl` if there is one."""
    if level not in LEVELS:
        raise ConfigError(f"log level '{level}'; choose one of {', '.join(LEVELS)}")
    root = logging.getLogger()
    root.setLevel(LEVELS[level])
    root.handlers.clear()
    terminal = logging.StreamHandler(sys.stderr)
    terminal.setFormatter(
        logging.Formatter(f"%(asctime)s {service:<10} %(levelname)-7s %(message)s", "%H:%M:%S")
    )
    root.addHandler(terminal)
    if run_directory:
        directory = Path(run_directory)
        try:
            directory.mkdir(parents=True, exist_ok=True)
            file = logging.FileHandler(directory / f"{service}.jsonl")
        except OSError as error:
            raise ConfigError(
                f"cannot write logs into {directory}: {error}; choose another --run-directory"
            ) from error
        file.setFormatter(JsonFormatter())
        root.addHandler(file)


class BusHandler(logging.Handler):
    """Publishes what is logged, so that the recording has it."""

    def __init__(self, bus: Bus) -> None:
        super().__init__(logging.INFO)
        self._bus = bus

    def emit(self, record: logging.LogRecord) -> None:
        """Publish one record; one that cannot be published is counted, never raised."""
        try:
            self._bus.publish(
                topics.LOG,
                LogRecord(
                    stamp_ns=time.time_ns(),
                    level=record.levelname.lower(),
                    logger=record.name[:100],
                    text=record.getMessage()[:20_000],
                    fields={key: value[:1000] for key, value in extra_fields(record).items()},
                ),
            )
        except (BusError, MessageError):
            self._bus.count("log not published")


@contextmanager
def logs_on(bus: Bus) -> Iterator[None]:
    """Publish the log of this process while the block runs."""
    handler = BusHandler(bus)
    logging.getLogger().addHandler(handler)
    try:
        yield
    finally:
        logging.getLogger().removeHandler(handler)
