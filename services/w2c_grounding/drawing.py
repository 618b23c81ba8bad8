"""Evidence drawn over a picture, for people."""

import cv2
import numpy as np

from w2c.messages import GroundingReply, PhraseEvidence
from w2c_grounding.family import RgbImage

_Colour = tuple[int, int, int]

_HEAT_OPACITY = 0.6


def draw_reply(image: RgbImage, reply: GroundingReply) -> RgbImage:
    """Return the picture with heat, boxes, points and scores, one colour a phrase."""
    canvas = image.astype(np.float32)
    colours = [_colour(index, len(reply.evidence)) for index in range(len(reply.evidence))]
    for evidence, colour in zip(reply.evidence, colours, strict=True):
        if evidence.heatmap is not None:
            heat = cv2.resize(evidence.heatmap, (image.shape[1], image.shape[0])) / 255.0
            weight = _HEAT_OPACITY * heat[:, :, np.newaxis]
            canvas = canvas * (1.0 - weight) + np.asarray(colour) * weight
    drawn = np.ascontiguousarray(np.clip(canvas, 0, 255).astype(np.uint8))
    for row, (evidence, colour) in enumerate(zip(reply.evidence, colours, strict=True)):
        _draw_boxes(drawn, evidence, colour)
        answer = f"{evidence.score:.2f}" if evidence.found else "not found"
        _write(drawn, f"{evidence.phrase}: {answer}", (10, 30 + 30 * row), colour)
    return drawn


def _colour(index: int, count: int) -> _Colour:
    """Return a bright colour, far from those of the other phrases."""
    hue = np.array([[[round(179 * index / count), 255, 255]]], dtype=np.uint8)
    red, green, blue = (int(value) for value in cv2.cvtColor(hue, cv2.COLOR_HSV2RGB)[0, 0])
    return red, green, blue


def _draw_boxes(canvas: RgbImage, evidence: PhraseEvidence, colour: _Colour) -> None:
    for box in evidence.boxes:
        first = round(box.left), round(box.top)
        last = round(box.right) - 1, round(box.bottom) - 1
        cv2.rectangle(canvas, first, last, colour, 2)
        _write(canvas, f"{box.score:.2f}", (first[0], max(16, first[1] - 6)), colour)
    if evidence.point is not None:
        centre = int(evidence.point[0]), int(evidence.point[1])
        cv2.drawMarker(canvas, centre, (255, 255, 255), cv2.MARKER_CROSS, 26, 5)
        cv2.drawMarker(canvas, centre, colour, cv2.MARKER_CROSS, 22, 2)


def _write(canvas: RgbImage, text: str, at: tuple[int, int], colour: _Colour) -> None:
    # Dark below light: readable on any background.
    cv2.putText(canvas, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.7, (0, 0, 0), 4, cv2.LINE_AA)
    cv2.putText(canvas, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.7, colour, 1, cv2.LINE_AA)
