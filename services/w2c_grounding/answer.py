"""A request in, a reply out: the same for the process on the bus and for the command line."""

import hashlib
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from w2c import messages as m
from w2c_grounding.card import ModelCard
from w2c_grounding.evidence import PointRule, find, thumbnail
from w2c_grounding.family import Evidence, Family
from w2c_grounding.picture import decode
from w2c_grounding.wording import normalised, spelt_as_known, unknown_words

_REMEMBERED_PICTURES = 4
"""The operator's frame and those around it: a turn asks about one picture several times."""

HEAT_AT_ONCE = 32_000_000
"""Pixels of heatmaps held at a time (128 MB): thirty-odd phrases on a camera picture, one on a
picture of 40 megapixels."""


@dataclass(frozen=True)
class Seen:
    """A picture as the model keeps it."""

    width: int
    height: int
    context: Any
    """Of the family; opaque here"""


class Grounder:
    """Answers requests with one model. Not thread-safe: the caller takes turns."""

    def __init__(
        self,
        family: Family[Any],
        card: ModelCard,
        rule: PointRule = "interior",
        timer: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self._family = family
        self._card = card
        self._rule: PointRule = rule
        self._timer = timer
        self._seen: OrderedDict[bytes, Seen] = OrderedDict()
        self.dropped_boxes = 0
        """Boxes of the model, since the start, that made no sense and were left out"""

    def ground(self, request: m.GroundingRequest) -> m.GroundingReply:
        """Answer every phrase of a request.

        Raises:
            RefusedError: the picture cannot be decoded, a phrase holds no word, or memory ran out.
        """
        started = self._timer()
        vocabulary = self._card.vocabulary
        texts = [spelt_as_known(normalised(phrase), vocabulary) for phrase in request.phrases]
        seen = self._see(request.jpeg)
        together = max(1, HEAT_AT_ONCE // (seen.width * seen.height))
        answers: list[m.PhraseEvidence] = []
        for start in range(0, len(texts), together):
            evidence = self._family.query(seen.context, texts[start : start + together])
            answers += [
                self._answer(phrase, text, one, with_heatmap=request.want == "heatmaps")
                for phrase, text, one in zip(
                    request.phrases[start:], texts[start:], evidence, strict=False
                )
            ]
        return m.GroundingReply(
            model=self._card.name,
            width=seen.width,
            height=seen.height,
            evidence=answers,
            milliseconds=(self._timer() - started) * 1e-6,
        )

    def _see(self, picture: bytes) -> Seen:
        """Return what the model keeps of a picture; decoded and encoded once for the same bytes."""
        key = hashlib.blake2b(picture, digest_size=16).digest()
        seen = self._seen.pop(key, None)
        if seen is None:
            image = decode(picture)
            seen = Seen(image.shape[1], image.shape[0], self._family.prepare(image))
        self._seen[key] = seen
        while len(self._seen) > _REMEMBERED_PICTURES:
            self._seen.popitem(last=False)
        return seen

    def _answer(
        self, phrase: str, text: str, evidence: Evidence, *, with_heatmap: bool
    ) -> m.PhraseEvidence:
        """Return the evidence of a phrase, which the model was shown as `text`."""
        card = self._card
        finding = find(evidence.heatmap, card.threshold, self._rule, evidence.boxes, card.edge)
        self.dropped_boxes += finding.dropped_boxes
        boxes = [
            m.Box(
                left=float(region.left),
                top=float(region.top),
                right=float(region.right),
                bottom=float(region.bottom),
                score=region.score,
            )
            for region in finding.regions
        ]
        return m.PhraseEvidence(
            phrase=phrase,
            found=finding.found,
            score=finding.score,
            point=finding.point,
            boxes=boxes,
            heatmap=thumbnail(evidence.heatmap) if with_heatmap else None,
            unknown_words=list(
                dict.fromkeys([*unknown_words(text, card.vocabulary), *evidence.unknown_words])
            ),
        )
