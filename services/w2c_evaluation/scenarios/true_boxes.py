"""Where things are in a picture, known for certain: a stand-in for the grounding service.

It answers for the evaluation only, on private endpoints, and is marked in the results. The product
asks it as it asks the real one.
"""

import hashlib
import time
from collections import OrderedDict
from dataclasses import dataclass

import cv2
import numpy as np

from w2c import topics
from w2c.bus import Bus, CallContext
from w2c.errors import RefusedError
from w2c.messages import Array, Box, GroundingReply, GroundingRequest, PhraseEvidence
from w2c_evaluation.scenarios.eyewitness import Witness
from w2c_evaluation.scenarios.phrase_book import PhraseBook
from w2c_evaluation.scenarios.sight import Pixel
from w2c_evaluation.scenarios.truth_log import TruthLog

NAME = "truth"
MOST_RAYS = 6000
"""Of one object: a third of a second"""
FINEST_STEP = 2
"""Between two rays [px]"""
MAP_SCALE = 4
"""Pixels of the picture for one of a heatmap"""
INNER_SHARE = 0.9
"""Of the largest distance to the edge, which a long thing has along a line"""
KEPT_FRAMES = 60
"""As many as wait to be read: twenty seconds"""
FRAME_PATIENCE_S = 2.0
"""The picture that is asked about may still be on its way."""


@dataclass(frozen=True)
class Seen:
    """The visible part of one object."""

    mask: Array
    """(rows, columns) bool, one sample every `step` pixels"""
    left: int
    top: int
    """Of the first sample's cell [px]"""
    step: int

    @property
    def pixels(self) -> int:
        """Return the visible area [px]."""
        return int(self.mask.sum()) * self.step**2

    def box(self) -> Box:
        """Return the box around it, certain."""
        rows, columns = np.nonzero(self.mask)
        return Box(
            left=float(self.left + self.step * columns.min()),
            top=float(self.top + self.step * rows.min()),
            right=float(self.left + self.step * (columns.max() + 1)),
            bottom=float(self.top + self.step * (rows.max() + 1)),
            score=1.0,
        )

    def point(self) -> Pixel:
        """Return a pixel far from its edge, of those the nearest to its middle."""
        padded = np.pad(self.mask.astype(np.uint8), 1)
        distance = cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
        inner = np.argwhere(distance >= INNER_SHARE * distance.max())
        middle = np.argwhere(self.mask).mean(axis=0)
        row, column = inner[np.linalg.norm(inner - middle, axis=1).argmin()].tolist()
        return self.left + self.step * (column + 0.5), self.top + self.step * (row + 0.5)

    def heatmap(self, size: tuple[int, int]) -> Array:
        """Return (h, w) uint8 over the whole picture of this (width, height), smaller."""
        result = np.zeros((size[1] // MAP_SCALE, size[0] // MAP_SCALE), np.uint8)
        rows, columns = np.nonzero(self.mask)
        u = (self.left + self.step * (columns + 0.5)).astype(int) // MAP_SCALE
        v = (self.top + self.step * (rows + 0.5)).astype(int) // MAP_SCALE
        result[np.clip(v, 0, result.shape[0] - 1), np.clip(u, 0, result.shape[1] - 1)] = 255
        return result


def see(witness: Witness, name: str) -> Seen | None:
    """Return the visible part of an object; None where nothing of it is to be seen."""
    thing = next(item for item in witness.objects if item.name == name)
    world_from_object = witness.world_from_object(name)
    width, height = witness.size
    camera_from_world = np.linalg.inv(witness.world_from_camera())
    in_object = np.array(
        [
            (x * thing.size[0], y * thing.size[1], z * thing.size[2], 1.0)
            for x in (-0.5, 0.5)
            for y in (-0.5, 0.5)
            for z in (0.0, 1.0)
        ]
    )
    in_camera = (camera_from_world @ world_from_object @ in_object.T).T[:, :3]
    # What reaches behind the camera may be anywhere in the picture.
    if in_camera[:, 2].min() < 0.05:
        left, top, right, bottom = 0, 0, width, height
    else:
        pixels = np.array([witness.intrinsics.pixel_from_point(corner) for corner in in_camera])
        left, top = np.maximum(np.floor(pixels.min(axis=0)), 0).astype(int).tolist()
        right, bottom = (
            np.minimum(np.ceil(pixels.max(axis=0)), (width, height)).astype(int).tolist()
        )
    if right <= left or bottom <= top:
        return None
    step = max(FINEST_STEP, int(np.ceil(np.sqrt((right - left) * (bottom - top) / MOST_RAYS))))
    u = np.arange(left + 0.5 * step, right, step)
    v = np.arange(top + 0.5 * step, bottom, step)
    grid = np.column_stack([np.tile(u, len(v)), np.repeat(v, len(u))])
    mask = np.array([owner == name for owner in witness.owners(grid)]).reshape(len(v), len(u))
    return Seen(mask, left, top, step) if mask.any() else None


class TrueGrounding:
    """Answers `grounding/ground` from truth, on a bus that was opened as `grounding`."""

    def __init__(
        self, bus: Bus, log: TruthLog, book: PhraseBook, *, patience_s: float = FRAME_PATIENCE_S
    ) -> None:
        self._frames = bus.queue(topics.CAMERA_FRAME, size=KEPT_FRAMES)
        self._log = log
        self._book = book
        self._patience_s = patience_s
        self._stamps: OrderedDict[bytes, int] = OrderedDict()
        bus.serve(topics.GROUND, self.ground)

    def ground(self, request: GroundingRequest, _context: CallContext) -> GroundingReply:
        """Answer. Raises RefusedError for a picture that the head camera did not take."""
        start = time.monotonic()
        stamp_ns = self._stamp_of(request.jpeg)
        with self._log.moment(stamp_ns) as witness:
            evidence = [self._find(witness, phrase, request.want) for phrase in request.phrases]
            width, height = witness.size
        return GroundingReply(
            model=NAME,
            width=width,
            height=height,
            evidence=evidence,
            milliseconds=(time.monotonic() - start) * 1e3,
        )

    def _find(self, witness: Witness, phrase: str, want: str) -> PhraseEvidence:
        seen = [part for name in self._book.find(phrase) if (part := see(witness, name))]
        if not seen:
            return PhraseEvidence(phrase=phrase, found=False, score=0.0, point=None, boxes=[])
        seen.sort(key=lambda part: -part.pixels)
        return PhraseEvidence(
            phrase=phrase,
            found=True,
            score=1.0,
            point=seen[0].point(),
            boxes=[part.box() for part in seen],
            heatmap=seen[0].heatmap(witness.size) if want == "heatmaps" else None,
        )

    def _stamp_of(self, jpeg: bytes) -> int:
        key = _digest(jpeg)
        deadline = time.monotonic() + self._patience_s
        while True:
            wait_s = 0.0 if key in self._stamps else deadline - time.monotonic()
            received = self._frames.receive(max(0.0, wait_s))
            if received is None:
                break
            self._stamps[_digest(received.message.jpeg)] = received.message.stamp_ns
        while len(self._stamps) > KEPT_FRAMES:
            self._stamps.popitem(last=False)
        if key not in self._stamps:
            raise RefusedError("truth is known of the head camera's last pictures only")
        return self._stamps[key]


def _digest(jpeg: bytes) -> bytes:
    return hashlib.blake2b(jpeg, digest_size=16).digest()
