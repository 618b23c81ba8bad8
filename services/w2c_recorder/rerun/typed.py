"""What Rerun keeps as messages of Foxglove, in columns of its own; and the story as text."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow
import rerun as rr
from rerun.chunk import Chunk

from w2c_recorder.timeline import Entry

LOG_TIME, PUBLISH_TIME, STAMP = "message_log_time", "message_publish_time", "timestamp"
"""Timelines, named by Rerun: arrival at the recorder; sending; the time in a Foxglove message,
which in these is that of sending"""
DOT_PX = 5.0

_QUANTITIES = ("position", "velocity", "effort")


@dataclass(frozen=True)
class _Rows:
    """Messages of one topic, with their times."""

    entity: str
    times: list[Any]
    """A TimeColumn a timeline"""
    messages: list[dict[str, Any]]
    """As protobuf has them; an empty list is None"""


class Typed:
    """Converts what Rerun has no columns for: joint states, scenes, and marks in the picture.

    It has columns for pictures, calibrations, clouds, transforms and logs; those pass unchanged.
    """

    def __init__(self) -> None:
        self._named: dict[str, list[str]] = {}
        self._convert: dict[str, Callable[[_Rows], Iterator[Chunk]]] = {
            "foxglove.JointStates:message": self._joints,
            "foxglove.SceneUpdate:message": _scenes,
        }

    def chunks(self, source: Iterable[Chunk]) -> Iterator[Chunk]:
        """Yield all of what was read from a file with channels for Foxglove."""
        picture_frames: dict[str, str] = {}
        marks: list[_Rows] = []
        for chunk in source:
            batch = chunk.to_record_batch()
            names = set(batch.schema.names)
            if {"EncodedImage:blob", "CoordinateFrame:frame"} <= names:
                frame = batch.column("CoordinateFrame:frame")[0].as_py()[0]
                picture_frames[_parent(chunk.entity_path)] = frame
            if "foxglove.ImageAnnotations:message" in names:
                # Drawn in the frame of the picture, which the message does not tell.
                marks.append(_rows(chunk, batch, "foxglove.ImageAnnotations:message"))
                continue
            found = names & self._convert.keys()
            if not found:
                yield chunk
            for name in found:
                yield from self._convert[name](_rows(chunk, batch, name))
        for rows in marks:
            yield from _marks(rows, picture_frames.get(_parent(rows.entity), ""))

    def _joints(self, rows: _Rows) -> Iterator[Chunk]:
        """Yield a series a joint, for each quantity."""
        states = [message["joints"] or [] for message in rows.messages]
        counts = [len(joints) for joints in states]
        names = [joint["name"] for joint in states[-1]]
        for quantity in _QUANTITIES:
            entity = f"{rows.entity}/{quantity}"
            values = [joint[quantity] for joints in states for joint in joints]
            scalars = rr.Scalars.columns(scalars=values).partition(counts)
            yield Chunk.from_columns(entity, rows.times, scalars)
            if self._named.get(entity) != names:
                self._named[entity] = names
                lines = rr.SeriesLines.columns(names=names).partition([len(names)])
                yield Chunk.from_columns(entity, [], lines)


def story(entries: Iterable[Entry], start_ns: int) -> Iterator[Chunk]:
    """Yield the timeline of a recording as text logs, an entity a kind of line.

    Args:
        entries: of the timeline.
        start_ns: arrival of the first message [ns since 1970].
    """
    by_kind: dict[str, list[Entry]] = {}
    for entry in entries:
        by_kind.setdefault(entry.kind, []).append(entry)
    for kind, told in by_kind.items():
        times = [start_ns + round(entry.seconds * 1e9) for entry in told]
        lines = rr.TextLog.columns(
            text=[f"{entry.actor}: {entry.text}" for entry in told],
            level=["WARN" if kind == "warning" else "INFO"] * len(told),
        )
        yield Chunk.from_columns(f"/story/{kind}", [_time(LOG_TIME, times)], lines)


def archetypes(chunk: Chunk) -> set[str]:
    """Return the archetypes that a chunk has columns of; of a message, its type."""
    names = chunk.to_record_batch().schema.names
    return {name.partition(":")[0] for name in names if ":" in name}


def _scenes(rows: _Rows) -> Iterator[Chunk]:
    """Yield the lines of the robot, or the ball of the target, in the world."""
    entities = [(message["entities"] or [{}])[0] for message in rows.messages]
    frames = rr.CoordinateFrame.columns(frame=[one.get("frame_id") or "" for one in entities])
    lines = [(one.get("lines") or [None])[0] for one in entities]
    balls = [(one.get("spheres") or [None])[0] for one in entities]
    if any(lines):
        ends = [_points((line or {}).get("points"), "xyz").reshape(-1, 2, 3) for line in lines]
        strips = rr.LineStrips3D.columns(strips=np.concatenate(ends))
        look = rr.LineStrips3D.columns(
            radii=[line["thickness"] / 2 if line else 0.0 for line in lines],
            colors=[_rgba((line or {}).get("color")) for line in lines],
        )
        columns = [*strips.partition([len(pairs) for pairs in ends]), *look, *frames]
        yield Chunk.from_columns(rows.entity, rows.times, columns)
    if any(balls):
        centres = [_points([ball["pose"]["position"]] if ball else [], "xyz") for ball in balls]
        positions = rr.Points3D.columns(positions=np.concatenate(centres))
        look = rr.Points3D.columns(
            radii=[ball["size"]["x"] / 2 if ball else 0.0 for ball in balls],
            colors=[_rgba((ball or {}).get("color")) for ball in balls],
        )
        columns = [*positions.partition([len(found) for found in centres]), *look, *frames]
        yield Chunk.from_columns(rows.entity, rows.times, columns)


def _marks(rows: _Rows, frame: str) -> Iterator[Chunk]:
    """Yield the target and the boxes in the picture [px]."""
    frames = list(rr.CoordinateFrame.columns(frame=[frame] * len(rows.messages))) if frame else []
    circles = [message["circles"] or [] for message in rows.messages]
    centres = [_points([one["position"] for one in found], "xy") for found in circles]
    dots = rr.Points2D.columns(positions=np.concatenate(centres))
    look = rr.Points2D.columns(
        radii=[DOT_PX] * len(circles),
        colors=[_rgba(found[0]["outline_color"] if found else None) for found in circles],
    )
    columns = [*dots.partition([len(found) for found in centres]), *look, *frames]
    yield Chunk.from_columns(f"{rows.entity}/point", rows.times, columns)

    outlines = [message["points"] or [] for message in rows.messages]
    corners = [_points(one["points"], "xy") for found in outlines for one in found]
    least = np.array([points.min(axis=0) for points in corners]).reshape(-1, 2)
    most = np.array([points.max(axis=0) for points in corners]).reshape(-1, 2)
    counts = [len(found) for found in outlines]
    labels = [
        label
        for message, count in zip(rows.messages, counts, strict=True)
        for label in ([one["text"] for one in message["texts"] or []] + [""] * count)[:count]
    ]
    boxes = rr.Boxes2D.columns(
        centers=(least + most) / 2, half_sizes=(most - least) / 2, labels=labels
    )
    columns = [*boxes.partition(counts), *frames]
    yield Chunk.from_columns(f"{rows.entity}/boxes", rows.times, columns)


def _rows(chunk: Chunk, batch: pyarrow.RecordBatch, name: str) -> _Rows:
    times = [
        _time(timeline, batch.column(column).cast(pyarrow.int64()).to_pylist())
        for timeline, column in (
            (LOG_TIME, LOG_TIME),
            (PUBLISH_TIME, PUBLISH_TIME),
            (STAMP, PUBLISH_TIME),
        )
    ]
    messages = [row[0] for row in batch.column(name).to_pylist()]
    return _Rows(chunk.entity_path, times, messages)


def _time(name: str, nanoseconds: list[int]) -> Any:
    return rr.TimeColumn(name, timestamp=np.array(nanoseconds, dtype="datetime64[ns]"))


def _points(points: list[dict[str, float]] | None, axes: str) -> Any:
    """Return points as an array (n, number of axes)."""
    values = [[point[axis] for axis in axes] for point in points or []]
    return np.array(values, dtype=np.float64).reshape(-1, len(axes))


def _rgba(colour: dict[str, float] | None) -> list[int]:
    return [round(255 * (colour or {}).get(part, 1.0)) for part in "rgba"]


def _parent(entity: str) -> str:
    return entity.rpartition("/")[0]
