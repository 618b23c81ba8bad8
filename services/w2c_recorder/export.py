"""Recordings in the formats of other programs."""

import csv
import json
import os
import tempfile
from argparse import Namespace
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from w2c import messages as m
from w2c import topics
from w2c.errors import ConfigError, W2CError
from w2c.extras import needs_extra
from w2c.library import library
from w2c_recorder.columns import TIMES, Kind, Row, Span, common_kind, rows_of
from w2c_recorder.conversations import Conversation, conversations_of
from w2c_recorder.dataset import Camera, Values, conversation_values, training_lines
from w2c_recorder.history import History, history_of
from w2c_recorder.pictures import frames_of
from w2c_recorder.reading import Recording
from w2c_recorder.report import Report, write_file
from w2c_recorder.whole_file import whole_file


def export(options: Namespace) -> Report:
    """Write a recording in another format. Raises RecordingError, ConfigError."""
    return _FORMATS[options.to](options)


def _table(options: Namespace) -> Report:
    """Write one stream as a table: a row a message, a column a number."""
    if not options.channel:
        raise ConfigError(f"--to {options.to} needs --channel, as in: --channel state/robot/joints")
    out = options.out or Path(f"{options.channel.replace('/', '-')}.{options.to}")
    source = Recording(options.file)
    span = Span(options.start, float("inf") if options.end is None else options.end)
    # Twice through the file: which columns there are is known only at its end.
    kinds: dict[str, Kind] = dict.fromkeys(TIMES, int)
    for row in rows_of(source, options.channel, span):
        for name, cell in row.items():
            kinds[name] = common_kind(kinds.get(name), cell)
    rows = rows_of(source, options.channel, span)
    if options.to == "csv":
        count = _write_rows(out, list(kinds), rows)
    else:
        with needs_extra("parquet"):
            from w2c_recorder.parquet import write_parquet
        count = write_parquet(out, kinds, rows)
    lines = [f"table: {out}, {count} rows, {len(kinds)} columns"]
    return Report(lines + source.damage.lines(), status=0 if count else 1)


def _write_rows(out: Path, columns: list[str], rows: Iterable[Row]) -> int:
    count = 0
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with out.open("w", newline="") as file:
            writer = csv.DictWriter(file, columns, restval="")
            writer.writeheader()
            for row in rows:
                writer.writerow(row)
                count += 1
    except OSError as error:
        raise ConfigError(
            f"{out} cannot be written: {error.strerror}; choose another --out"
        ) from error
    return count


def _dataset(options: Namespace) -> Report:
    """Write the conversations: lines for training, all that is known, and the pictures."""
    out = options.out or Path(options.file.stem + "-dataset")
    source = Recording(options.file)
    history = history_of(source)
    conversations = list(conversations_of(history))
    cameras, pictures = _pictures(source, history, conversations, out)
    refuses = _checked_by(library("dialogue_examples"))
    lines = [
        line
        for conversation in conversations
        for line in training_lines(history, conversation, options.file.stem, cameras, refuses)
    ]
    known = [conversation_values(history, one, pictures) for one in conversations]
    write_file(out / "dialogues.jsonl", _json_lines(lines))
    write_file(out / "conversations.jsonl", _json_lines(known))
    confirmed = sum(one.confirmation is not None for one in conversations)
    report = [
        f"{out / 'dialogues.jsonl'}: {len(lines)} lines for `w2c train language --with`, "
        f"of {confirmed} conversations with a yes",
        f"{out / 'conversations.jsonl'}: {len(known)} conversations",
        f"{out / 'pictures'}: {len(pictures)} pictures",
    ]
    return Report(report + source.damage.lines(), status=0 if known else 1)


def _pictures(
    source: Recording, history: History, conversations: list[Conversation], out: Path
) -> tuple[dict[int, Camera], dict[int, str]]:
    """Write the pictures of all targets; return what is known of each, and its file, by stamp."""
    wanted = {}
    for conversation in conversations:
        for turn in conversation.turns:
            target = turn.message.target
            frame = None if target is None else history.frame_of(target, turn.at_ns)
            if frame is not None:
                wanted[frame.stamp_ns] = frame
    views = {
        recorded.message.stamp_ns: recorded.message
        for recorded in source.of(topics.CAMERA_VIEW)
        if isinstance(recorded.message, m.CameraView) and recorded.message.stamp_ns in wanted
    }
    cameras, names = {}, {}
    for picture in frames_of(source, wanted.values()).values():
        name = f"pictures/{picture.stamp_ns}.jpg"
        write_file(out / name, picture.jpeg)
        names[picture.stamp_ns] = name
        view = views.get(picture.stamp_ns)
        cameras[picture.stamp_ns] = Camera(picture.width, picture.height, view)
    return cameras, names


def _film(options: Namespace) -> Report:
    """Write the camera's pictures as a film."""
    from w2c_recorder.film import write_film

    out = options.out or Path(options.file.stem + ".mp4")
    source = Recording(options.file)
    count = write_film(source, out)
    return Report([f"film: {out}, {count} pictures", *source.damage.lines()])


def _checked_by(read: Any) -> Any:
    """Return the check of a line by the very reader that training uses."""

    def refuses(line: Values) -> str:
        with tempfile.TemporaryDirectory() as directory:
            path = Path(directory) / "line.jsonl"
            path.write_bytes(_json_lines([line]))
            try:
                read(path)
            except W2CError as error:
                return str(error)
        return ""

    return refuses


def _foxglove(options: Namespace) -> Report:
    """Write the same recording with channels for Foxglove and Rerun beside its own."""
    from w2c_recorder.foxglove.copy import copy_shown

    out = options.out or options.file.with_name(f"{options.file.stem}-foxglove.mcap")
    source = Recording(options.file)
    with whole_file(out) as unfinished:
        copied = copy_shown(source, unfinished)
    lines = [f"recording: {out}, {copied.messages} messages, {copied.shown} for Foxglove and Rerun"]
    lines += _still(copied.problem) + source.damage.lines()
    return Report(lines, status=0 if copied.shown else 1)


def _rerun(options: Namespace) -> Report:
    """Write pictures, camera, robot, joints, target and story in Rerun's own columns."""
    # Its viewer tells its makers how it is used. Reading and writing files does not; should a newer
    # version think of it, this is how it is told no.
    os.environ["RERUN_ANALYTICS"] = "0"
    with needs_extra("rerun"):
        from w2c_recorder.rerun.write import write_rrd

    out = options.out or Path(options.file.stem + ".rrd")
    source = Recording(options.file)
    written = write_rrd(source, out)
    rows = ", ".join(f"{count} {name}" for name, count in sorted(written.rows.items()))
    lines = [f"rerun: {out}, {rows or 'nothing that it shows'}", *_still(written.problem)]
    return Report(lines + source.damage.lines(), status=0 if written.rows else 1)


def _still(problem: str) -> list[str]:
    return [f"the robot is not shown as it moves: {problem}"] if problem else []


def _json_lines(values: Iterable[Values]) -> bytes:
    return b"".join(json.dumps(one, ensure_ascii=False).encode() + b"\n" for one in values)


_FORMATS = {
    "csv": _table,
    "parquet": _table,
    "dataset": _dataset,
    "foxglove": _foxglove,
    "mp4": _film,
    "rerun": _rerun,
}
