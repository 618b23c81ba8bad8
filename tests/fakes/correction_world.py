"""A picture of two things with its truth, a robot and a language model that know few words."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import msgspec
import numpy as np

from w2c import topics
from w2c.bus import CallContext, InProcessHub
from w2c.messages import (
    ChooseReply,
    ChooseRequest,
    CompleteReply,
    CompleteRequest,
    Target,
    Turn,
)
from w2c_evaluation.corrections.pictures import Picture, read_picture

SEED = 900_007
SIZE = (640, 360)
DEPTH_M = 0.8
BLOCK = (200, 120, 280, 200)
BALL = (400, 150, 460, 210)


def write_picture(directory: Path, seed: int = SEED) -> Picture:
    """Write a picture as `w2c scenes render` does: a red block and a blue ball on a table."""
    directory.mkdir(parents=True, exist_ok=True)
    width, height = SIZE
    name = f"{seed:07d}"
    identity = np.full((height, width), 1, np.uint8)
    objects = [_object(1, "table", "white", (0, 0, width, height), movable=False)]
    for number, (kind, colour, box) in enumerate(
        (("block", "red", BLOCK), ("ball", "blue", BALL)), start=2
    ):
        left, top, right, bottom = box
        identity[top:bottom, left:right] = number
        objects.append(_object(number, kind, colour, box, movable=True))
    picture = np.stack([40 * identity] * 3, axis=-1)
    cv2.imwrite(str(directory / f"{name}.jpg"), picture)
    cv2.imwrite(str(directory / f"{name}_identity.png"), identity)
    depth = np.full((height, width), round(DEPTH_M / 0.00025), np.uint16)
    cv2.imwrite(str(directory / f"{name}_depth.png"), depth)
    truth = {
        "image": f"{name}.jpg",
        "identity": f"{name}_identity.png",
        "width": width,
        "height": height,
        "intrinsics": [400.0, 400.0, 320.0, 180.0],
        "world_from_camera": np.eye(4).tolist(),
        "objects": objects,
    }
    (directory / f"{name}.json").write_bytes(msgspec.json.encode(truth))
    return read_picture(directory, seed)


def _object(
    number: int, kind: str, colour: str, box: tuple[int, int, int, int], *, movable: bool
) -> dict[str, object]:
    return {
        "id": number,
        "name": f"{kind}_0",
        "colour": colour,
        "names": [kind],
        "phrases": [kind, f"{colour} {kind}"],
        "box": list(box),
        "visible_pixels": (box[2] - box[0]) * (box[3] - box[1]),
        "movable": movable,
    }


def turn(
    point: tuple[float, float] | None = None,
    *,
    module: str = "correction",
    reply: str = "",
    options: Sequence[str] = (),
    state: str = "proposed",
) -> Turn:
    """Return an answer: a dot, a question, or a failure where there is neither."""
    target = None
    if point is not None:
        target = Target(
            target_id="t",
            frame_stamp_ns=1,
            u=point[0],
            v=point[1],
            point=None,
            normal=None,
            state=state,  # type: ignore[arg-type]
            corrections=0,
            instruction="",
            boxes=[],
            phrases=[],
        )
    return Turn(
        stamp_ns=1,
        text="",
        module="question" if options else module,
        reply=reply,
        ok=point is not None,
        options=list(options),
        target=target,
        seconds=0.1,
    )


class Told:
    """A stage whose robot gives these answers, whatever is said."""

    def __init__(self, turns: Sequence[Turn]) -> None:
        self.turns = list(turns)
        self.said: list[str] = []

    def begin(self, _picture: Picture) -> "Told":
        """Begin a conversation."""
        return self

    def say(self, text: str, _target_id: str) -> Turn:
        """Answer with the next turn."""
        self.said.append(text)
        return self.turns.pop(0)


def serve_words(hub: InProcessHub) -> None:
    """Serve a language model: `block` and `ball` are things, `right` moves the target by 5 cm."""
    bus = hub.connect("llm")

    def choose(request: ChooseRequest, _context: CallContext) -> ChooseReply:
        option = "correction" if "right" in request.messages[-1].content else "prediction"
        certain = {one: float(one == option) for one in request.options}
        return ChooseReply(
            option=option,
            probabilities=certain,
            model="words",
            prompt_tokens=1,
            reused_tokens=0,
            queue_ms=0.0,
            prefill_ms=0.0,
        )

    def complete(request: CompleteRequest, _context: CallContext) -> CompleteReply:
        words = request.messages[-1].content.split()
        spans = [
            f"{n}-{n}"
            for word in words
            if (n := word.lstrip("abcdefghijklmnopqrstuvwxyz"))
            and word.startswith(("block", "ball"))
        ]
        fields = request.schema["properties"]
        values = {
            "position": "absolute",
            "objects": spans,
            "x": "target.u+5*cm",
            "y": "target.v",
        }
        value = {name: values[name] for name in fields}
        return CompleteReply(
            text="",
            value=value,
            model="words",
            prompt_tokens=1,
            reused_tokens=0,
            completion_tokens=1,
            queue_ms=0.0,
            prefill_ms=0.0,
            decode_ms=0.0,
        )

    bus.serve(topics.CHOOSE, choose)
    bus.serve(topics.COMPLETE, complete)
