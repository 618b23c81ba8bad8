"""Draw what the system understood into the picture that it saw."""

import cv2
import numpy as np

from w2c.errors import RecordingError
from w2c.messages import Target

BLUE, YELLOW, GREY = (235, 130, 40), (40, 210, 250), (200, 200, 200)


def draw_target(jpeg: bytes, target: Target) -> bytes:
    """Return the JPEG with the target (blue: predicted, yellow: corrected) and the boxes."""
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise RecordingError("the camera's picture is no JPEG")
    for box, phrase in zip(target.boxes, target.phrases, strict=False):
        corner = (round(box.left), round(box.top))
        cv2.rectangle(image, corner, (round(box.right), round(box.bottom)), GREY, 2)
        cv2.putText(
            image, phrase, (corner[0], corner[1] - 8), cv2.FONT_HERSHEY_SIMPLEX, 0.7, GREY, 2
        )
    colour = YELLOW if target.corrections else BLUE
    centre = (round(target.u), round(target.v))
    cv2.circle(image, centre, 18, colour, 2, cv2.LINE_AA)
    cv2.circle(image, centre, 5, colour, -1, cv2.LINE_AA)
    done, encoded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 92])
    if not done:
        raise RecordingError("the picture could not be encoded")
    return bytes(encoded)
