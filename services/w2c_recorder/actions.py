"""What `w2c recording` does: one function an action, from its flags to a report."""

from argparse import Namespace
from dataclasses import asdict
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from w2c.errors import ConfigError
from w2c_recorder.mcap_file import SESSION_METADATA
from w2c_recorder.overview import Overview, overview_of
from w2c_recorder.reading import Recording
from w2c_recorder.report import Report, write_file
from w2c_recorder.timeline import Entry, timeline_of

if TYPE_CHECKING:
    from w2c_recorder.page import Picture

PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg")
CLOCK_TOLERANCE_S = 0.002
"""The recorder ties arrivals to the wall clock once a file; clocks are slewed meanwhile"""
SLOWEST_S = 0.5
"""No link takes this long for the fastest of many messages"""
MOST_PICTURE_BYTES = 100_000_000
"""On one page; a browser shows no more without pain"""


def info(options: Namespace) -> Report:
    """Channels, rates, losses, versions. Raises RecordingError."""
    overview = overview_of(Recording(options.file))
    start = datetime.fromtimestamp(overview.start_ns * 1e-9, UTC)
    files = f", {overview.files} files" if overview.files > 1 else ""
    lines = [
        f"{overview.path}: {overview.size_bytes / 1e6:.2f} MB, {overview.messages} messages{files}",
        f"from {start:%Y-%m-%d %H:%M:%S} UTC, {overview.duration_s:.1f} s",
    ]
    if overview.recovered:
        lines.append(f"recovered after a crash: {overview.recovered}")
    if overview.damage:
        lines.append(f"DAMAGED: {overview.damage}")
    lines += [f"  {name:<20} {value}" for name, value in overview.session.items()]
    lines += [
        f"  {name:<20} {facts['model']}, SHA-256 {facts.get('model_sha256', 'not known')}"
        for name, facts in overview.processes.items()
        if "model" in facts
    ]
    lines += _channel_lines(overview)
    lines += _clock_lines(overview)
    lines += [
        f"{topic}  {count} in another encoding" for topic, count in overview.elsewhere.items()
    ]
    channels = [{**asdict(channel), "rate_hz": channel.rate_hz} for channel in overview.channels]
    values = {**asdict(overview), "messages": overview.messages, "channels": channels}
    return Report(lines, values)


def _clock_lines(overview: Overview) -> list[str]:
    """Name the senders whose clock is not the recorder's."""
    lines = []
    for sender, age_s in overview.clocks.items():
        if age_s < -CLOCK_TOLERANCE_S:
            lines.append(f"CLOCK: that of {sender} is at least {-age_s:.3f} s ahead")
        elif age_s > SLOWEST_S:
            lines.append(
                f"CLOCK: that of {sender} is behind, or its messages take {age_s:.3f} s and more"
            )
    return lines


def _channel_lines(overview: Overview) -> list[str]:
    width = max((len(channel.key) for channel in overview.channels), default=3)
    named = max((len(channel.message or "unknown") for channel in overview.channels), default=7)
    lines = [
        f"{'key':<{width}}  {'message':<{named}} {'count':>8} {'Hz':>8} {'gap [ms]':>9} {'lost':>6}"
    ]
    for channel in overview.channels:
        notes = f"  {channel.malformed} MALFORMED" if channel.malformed else ""
        notes += f"  {channel.note}" if channel.note else ""
        lines.append(
            f"{channel.key:<{width}}  {channel.message or 'unknown':<{named}} {channel.count:>8} "
            f"{channel.rate_hz:>8.1f} {channel.longest_gap_ns * 1e-6:>9.1f} {channel.lost:>6}"
            f"{notes}"
        )
    return lines


def timeline(options: Namespace) -> Report:
    """Who said what, and what the robot did. Raises RecordingError, ConfigError."""
    source = Recording(options.file)
    entries = list(timeline_of(source))
    lines = []
    for entry in entries:
        minutes, seconds = divmod(entry.seconds, 60)
        lines.append(f"{minutes:3.0f}:{seconds:06.3f}  {entry.actor:<14} {entry.text}")
    if not entries:
        lines.append(f"nothing to tell: {_why_silent(source)}")
    lines += source.damage.lines()
    if options.html is not None:
        lines.append(_write_page(options, source, entries))
    values = {
        "path": str(options.file),
        "start_ns": source.start_ns,
        "entries": [_entry_values(entry) for entry in entries],
    }
    return Report(lines, values)


def _why_silent(source: Recording) -> str:
    known = next(source.messages(decode=False), None)
    return source.why_empty() if known is None else "no words, calls, goals or warnings are in it"


def _entry_values(entry: Entry) -> dict[str, object]:
    values: dict[str, object] = {
        "seconds": entry.seconds,
        "kind": entry.kind,
        "actor": entry.actor,
        "text": entry.text,
    }
    if entry.target is not None:
        target = entry.target
        values["target"] = {
            "id": target.target_id,
            "state": target.state,
            "pixel": [target.u, target.v],
            "point": None if target.point is None else target.point.tolist(),
            "frame_stamp_ns": target.frame_stamp_ns,
        }
    return values


def _write_page(options: Namespace, source: Recording, entries: list[Entry]) -> str:
    from w2c_recorder.page import make_page

    pictures = _pictures(source, entries)
    page = make_page(
        options.file.name, source.metadata.get(SESSION_METADATA, {}), entries, pictures
    )
    write_file(options.html, page.encode())
    return f"page: {options.html}, {len(pictures)} pictures, {len(page) / 1e6:.1f} MB"


def _pictures(source: Recording, entries: list[Entry]) -> dict[int, "Picture"]:
    """Return the picture of each answer that changed the target."""
    from w2c_recorder.history import history_of
    from w2c_recorder.overlay import overlay_of
    from w2c_recorder.pictures import frames_of, reference

    history = history_of(source)
    wanted, shown = {}, ("", 0.0, 0.0)
    for index, entry in enumerate(entries):
        target = entry.target
        if target is None or (target.target_id, target.u, target.v) == shown:
            continue
        shown = (target.target_id, target.u, target.v)
        frame = history.frame_of(target, history.start_ns + round(entry.seconds * 1e9))
        if frame is not None:
            wanted[index] = (frame, target)
    frames = frames_of(source, [frame for frame, _ in wanted.values()])
    found: dict[int, Picture] = {}
    size = 0
    for index, (frame, target) in wanted.items():
        picture = frames.get(reference(frame.source))
        size += 0 if picture is None else len(picture.jpeg)
        if picture is not None and size <= MOST_PICTURE_BYTES:
            found[index] = (picture, overlay_of(history, target))
    return found


def check(options: Namespace) -> Report:
    """Hold a recording against a budget. Raises RecordingError, ConfigError."""
    from w2c_recorder.budget import Budget, read_budget
    from w2c_recorder.check import findings, measure

    budget = Budget() if options.budget is None else read_budget(options.budget)
    source = Recording(options.file)
    figures = measure(source)
    found = list(findings(figures, budget))
    failed = [finding for finding in found if not finding.kept]
    lines = [finding.text() for finding in (found if options.all else failed)]
    lines += source.damage.lines()
    if figures.lock_step:
        lines.append(f"in lock step: rates of the robot are held against {figures.pace:.2f}x")
    lines.append(f"{len(found) - len(failed)} of {len(found)} limits kept")
    if not found:
        lines.append("nothing in this recording is limited by the budget")
    values = {"path": str(options.file), "findings": [asdict(finding) for finding in found]}
    return Report(lines, values, status=1 if failed or not found else 0)


def frame(options: Namespace) -> Report:
    """Draw the picture of an instant. Raises RecordingError, ConfigError."""
    if options.out.suffix.lower() not in PICTURE_SUFFIXES:
        raise ConfigError(
            f"--out {options.out} ends in none of {', '.join(PICTURE_SUFFIXES)}; choose one"
        )
    from w2c_recorder.drawing import caption, decode_picture, draw, encode_picture
    from w2c_recorder.history import history_of
    from w2c_recorder.pictures import frame_at

    source = Recording(options.file)
    history = history_of(source)
    at_ns = history.instant(options.at)
    picture, overlay = frame_at(source, history, at_ns, newest=options.newest)
    drawn = draw(decode_picture(picture.jpeg), overlay)
    turn = history.target_at(at_ns)
    said = [] if turn is None or not turn.message.text else [f'"{turn.message.text}"']
    caption(drawn, [f"{options.at:.3f} s, robot time {picture.stamp_ns * 1e-9:.3f} s", *said])
    write_file(options.out, encode_picture(drawn, options.out.suffix.lower()))
    where = overlay.label or "no target"
    if overlay.point is not None:
        where += f" at ({overlay.point[0]:.0f}, {overlay.point[1]:.0f})"
    heat = ", with heat" if overlay.heat else ""
    return Report([f"picture: {options.out}; {where}, {len(overlay.boxes)} boxes{heat}"])


def export(options: Namespace) -> Report:
    """Write a recording for other programs. Raises RecordingError, ConfigError."""
    from w2c_recorder import export as formats

    return formats.export(options)


def why(options: Namespace) -> Report:
    """Follow a joint command back to the words. Raises RecordingError."""
    from w2c_recorder.history import history_of
    from w2c_recorder.why import explain, motion_at

    source = Recording(options.file)
    history = history_of(source)
    steps = list(explain(history, motion_at(source, history.instant(options.at))))
    lines = [
        f"{step.seconds:10.3f} s  {step.what:<12} {step.text}  <{step.link}>" for step in steps
    ]
    return Report(
        lines + source.damage.lines(),
        {"path": str(options.file), "at": options.at, "steps": [asdict(step) for step in steps]},
    )
