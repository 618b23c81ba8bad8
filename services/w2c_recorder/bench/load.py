"""A recorder under load, as a process that can be killed: `python -m w2c_recorder.bench.load`."""

import argparse
import json
import os
import threading
import time
from pathlib import Path

from w2c.bus import RawReceived
from w2c.bus.mailbox import Mailbox
from w2c_recorder.bench.traffic import ROBOT, Traffic
from w2c_recorder.config import RecorderConfig
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.writer_thread import WriterThread

SENT_SUFFIX = ".sent"
"""Of the file that tells how many bytes were sent so far, also after this process was killed"""

DRAIN_PATIENCE_S = 60.0


class TimedFile(McapFile):
    """Notes how long the writer's thread was held up."""

    longest_ns = 0

    def write(self, received: RawReceived, log_time_ns: int) -> None:
        """Write, and time it."""
        begin_ns = time.monotonic_ns()
        super().write(received, log_time_ns)
        TimedFile.longest_ns = max(TimedFile.longest_ns, time.monotonic_ns() - begin_ns)

    def flush(self) -> None:
        """Flush, and time it."""
        begin_ns = time.monotonic_ns()
        super().flush()
        TimedFile.longest_ns = max(TimedFile.longest_ns, time.monotonic_ns() - begin_ns)


def run(path: Path, bytes_per_s: float, seconds: float) -> dict[str, float]:
    """Record traffic from the recorder's queue on; return what that took.

    Returns:
        `sent_bytes`, `sending_s`, `backlog_s` until the last of them was written, `cpu_s` of the
        writer's thread, `longest_s` that one write took, `lost` messages, `file_bytes`.
    """
    dropped: list[int] = []
    mailbox: Mailbox[RawReceived] = Mailbox(
        RecorderConfig(robot=ROBOT).queue_size, lambda: dropped.append(1)
    )
    writer = WriterThread(mailbox, lambda file: TimedFile(file, {"robot": ROBOT}))
    (thread,) = [one for one in threading.enumerate() if one.name == "recorder-writer"]
    clock = time.pthread_getcpuclockid(thread.ident or 0)
    writer.start(path)
    sent, messages, begin, cpu = 0, 0, time.monotonic(), time.clock_gettime(clock)
    tally = os.open(path.with_suffix(SENT_SUFFIX), os.O_WRONLY | os.O_CREAT, 0o644)
    for raw in Traffic(bytes_per_s).messages(seconds):
        mailbox.put(raw)
        sent += len(raw.payload)
        messages += 1
        os.pwrite(tally, sent.to_bytes(8, "big"), 0)
    sending_s = time.monotonic() - begin
    _drain(writer, messages - len(dropped))
    backlog_s = time.monotonic() - begin - sending_s
    taken = time.clock_gettime(clock) - cpu
    progress = writer.stop()
    writer.shut_down()
    os.close(tally)
    return {
        "sent_bytes": sent,
        "sending_s": sending_s,
        "backlog_s": backlog_s,
        "cpu_s": taken,
        "longest_s": TimedFile.longest_ns * 1e-9,
        "lost": messages - progress.messages,
        "file_bytes": path.stat().st_size,
    }


def _drain(writer: WriterThread, messages: int) -> None:
    """Wait until so many messages are written."""
    deadline = time.monotonic() + DRAIN_PATIENCE_S
    while writer.progress.messages < messages and time.monotonic() < deadline:
        time.sleep(0.05)


def main() -> int:
    """Record, and print what it took as JSON."""
    parser = argparse.ArgumentParser()
    parser.add_argument("path", type=Path)
    parser.add_argument("--rate", type=float, required=True, help="[B/s]")
    parser.add_argument("--seconds", type=float, required=True)
    options = parser.parse_args()
    print(json.dumps(run(options.path, options.rate, options.seconds)))  # noqa: T201
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
