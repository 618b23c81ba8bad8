"""What is in a recording: channels, counts, rates, gaps, losses, versions."""

from dataclasses import dataclass

from w2c_recorder.losses import LossCounter
from w2c_recorder.mcap_file import SESSION_METADATA, head_of, message_type_of
from w2c_recorder.metadata import PROCESS_PREFIX
from w2c_recorder.reading import Recording
from w2c_recorder.recovery import RECOVERY_METADATA


@dataclass
class ChannelSummary:
    """One key of a recording."""

    key: str
    message: str
    """Type of the messages, empty where this version does not know the key."""
    count: int = 0
    bytes: int = 0
    first_ns: int = 0
    last_ns: int = 0
    longest_gap_ns: int = 0
    """Between two arrivals [ns]."""
    lost: int = 0
    """From gaps in the sequence numbers."""
    malformed: int = 0
    """Messages without a readable envelope."""
    note: str = ""
    """What is odd about the channel, for people."""

    @property
    def rate_hz(self) -> float:
        """Mean rate between the first and the last message; 0 where there are fewer than two."""
        span_ns = self.last_ns - self.first_ns
        return (self.count - 1) / (span_ns * 1e-9) if span_ns > 0 else 0.0


@dataclass(frozen=True)
class Overview:
    """A whole recording."""

    path: str
    size_bytes: int
    files: int
    """1, or as many as a rotated series has."""
    complete: bool
    """It was closed by its writer, or recovered since."""
    damage: str
    """What could not be read, for people; empty where everything could."""
    recovered: str
    """Why the file had to be recovered; empty where it had not."""
    start_ns: int
    """First arrival [ns since 1970]."""
    duration_s: float
    session: dict[str, str]
    """Versions, robot, host, run directory."""
    processes: dict[str, dict[str, str]]
    """SERVICE/INSTANCE -> configuration (JSON), file and SHA-256 of its model."""
    channels: list[ChannelSummary]
    clocks: dict[str, float]
    """Sender -> the least time that a message was on its way [s], by the clocks of both: what a
    clock that is ahead makes negative, and one that is behind makes large"""
    elsewhere: dict[str, int]
    """Topic -> messages in other encodings: repeats for Foxglove, or another program's."""

    @property
    def messages(self) -> int:
        """Messages of all channels."""
        return sum(channel.count for channel in self.channels)


def overview_of(recording: Recording) -> Overview:
    """Read a recording once and summarise it. Raises RecordingError."""
    channels: dict[str, ChannelSummary] = {}
    losses = LossCounter()
    clocks: dict[str, float] = {}
    end_ns = 0
    for recorded in recording.messages(decode=False):
        channel = channels.get(recorded.key)
        if channel is None:
            channel = _new_channel(recorded.key, recorded.log_time_ns)
            channels[recorded.key] = channel
        _count(channel, losses, clocks, recorded.payload, recorded.log_time_ns)
        end_ns = max(end_ns, recorded.log_time_ns)
    for key, count in losses.lost().items():
        channels[key].lost = count
    for key, name in recording.other_schemas().items():
        if key in channels:
            channels[key].note = f"another version of {name}"
    return Overview(
        path=str(recording.path),
        size_bytes=recording.size_bytes,
        files=len(recording.paths),
        complete=recording.damage.complete,
        damage=_describe_damage(recording),
        recovered=recording.metadata.get(RECOVERY_METADATA, {}).get("reason", ""),
        start_ns=recording.start_ns,
        duration_s=max(end_ns - recording.start_ns, 0) * 1e-9,
        session=recording.metadata.get(SESSION_METADATA, {}),
        processes={
            name.removeprefix(PROCESS_PREFIX): facts
            for name, facts in sorted(recording.metadata.items())
            if name.startswith(PROCESS_PREFIX)
        },
        clocks=dict(sorted(clocks.items())),
        elsewhere=dict(sorted(recording.elsewhere.items())),
        channels=sorted(channels.values(), key=lambda channel: channel.key),
    )


def _new_channel(key: str, log_time_ns: int) -> ChannelSummary:
    message_type = message_type_of(key)
    return ChannelSummary(
        key=key,
        message="" if message_type is None else message_type.__name__,
        first_ns=log_time_ns,
        last_ns=log_time_ns,
    )


def _count(
    channel: ChannelSummary,
    losses: LossCounter,
    clocks: dict[str, float],
    payload: bytes,
    log_time_ns: int,
) -> None:
    channel.count += 1
    channel.bytes += len(payload)
    channel.longest_gap_ns = max(channel.longest_gap_ns, log_time_ns - channel.last_ns)
    channel.last_ns = log_time_ns
    head = head_of(payload)
    if head is None:
        channel.malformed += 1
    else:
        losses.observe(channel.key, head.boot_id, head.sequence)
        age = (log_time_ns - head.clock_ns) * 1e-9
        clocks[head.sender] = min(age, clocks.get(head.sender, age))


def _describe_damage(recording: Recording) -> str:
    damage = recording.damage
    parts = [] if damage.complete else [f"not closed: {damage.reason}"]
    if damage.skipped_chunks:
        parts.append(f"{damage.skipped_chunks} damaged chunks skipped")
    if damage.orphans:
        parts.append(f"{damage.orphans} messages of channels whose description is lost")
    if damage.missing_files:
        parts.append(f"{damage.missing_files} files of this recording are not there")
    return "; ".join(parts)
