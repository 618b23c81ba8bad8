"""The services around a conversation about one picture, all in this process.

The language model, and the vision model where it looks, are the product's own services on a bus of
this process. In the robot's place is a picture with its depth; where things are may come from
truth.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any, Literal, Protocol

import numpy as np

from w2c import topics
from w2c.bus import CallContext, InProcessHub
from w2c.clock import RealClock
from w2c.errors import RefusedError
from w2c.geometry import Intrinsics
from w2c.library import library
from w2c.messages import (
    CameraView,
    GroundingReply,
    GroundingRequest,
    LiftReply,
    LiftRequest,
    PhraseEvidence,
    Turn,
)
from w2c_evaluation.corrections.pictures import Picture
from w2c_evaluation.scenarios.phrase_book import PhraseBook
from w2c_evaluation.scenarios.true_boxes import Seen

Boxes = Literal["model", "truth"]
STAMP_NS = 1
PATIENCE_S = 300.0
"""For one answer of a model: nobody waits here, and the machine may be busy"""


class Conversation(Protocol):
    """The dialogue of the product about one picture."""

    def say(self, text: str, target_id: str) -> Turn:
        """Answer words; `target_id` is what the operator sees."""


class Stage:
    """Where conversations take place, one picture at a time."""

    def __init__(self, hub: InProcessHub, *, seed: int, boxes: Boxes) -> None:
        """Serve depth, and truth where it is asked for.

        Args:
            hub: On which the language model serves.
            seed: Of the models' answers.
            boxes: Who finds things: `truth` here, `model` another service on the hub.
        """
        self._seed = seed
        self._bus = hub.connect("dialogue")
        self._perception = hub.connect("perception")
        self._perception.serve(topics.LIFT, self._lift)
        self._truth = hub.connect("grounding") if boxes == "truth" else None
        if self._truth is not None:
            self._truth.serve(topics.GROUND, self._ground)
        self._picture: Picture | None = None

    def begin(self, picture: Picture) -> Conversation:
        """Return a new conversation about a picture."""
        self._picture = picture
        truth = picture.truth
        view = CameraView(
            stamp_ns=STAMP_NS,
            world_from_camera=np.asarray(truth.world_from_camera),
            intrinsics=truth.intrinsics,
            width=truth.width,
            height=truth.height,
        )
        conversing: Any = library("conversing")
        conversation: Conversation = conversing(
            self._bus, picture.jpeg, view, seed=self._seed, model_timeout_s=PATIENCE_S
        )
        return conversation

    def close(self) -> None:
        """Leave the bus."""
        for bus in (self._bus, self._perception, self._truth):
            if bus is not None:
                bus.close()

    def _lift(self, request: LiftRequest, _context: CallContext) -> LiftReply:
        """Answer as perception does, with the depth of the picture."""
        picture = self._shown()
        surface: Any = library("lift")(
            picture.depth,
            Intrinsics(*picture.truth.intrinsics),
            np.asarray(picture.truth.world_from_camera),
            request.u,
            request.v,
            footprint=request.footprint,
        )
        return LiftReply(
            point=surface.point,
            normal=surface.normal,
            error_bound=surface.error_bound,
            flatness=surface.flatness,
            slope=surface.slope,
            extent=surface.extent,
            edge_distance=surface.edge_distance,
            frame_stamp_ns=STAMP_NS,
            warning=surface.warning,
        )

    def _ground(self, request: GroundingRequest, _context: CallContext) -> GroundingReply:
        """Answer from truth."""
        picture = self._shown()
        return GroundingReply(
            model="truth",
            width=picture.truth.width,
            height=picture.truth.height,
            evidence=[find_true(picture, phrase, request.want) for phrase in request.phrases],
            milliseconds=0.0,
        )

    def _shown(self) -> Picture:
        if self._picture is None:
            raise RefusedError("there is no picture yet; begin a conversation first")
        return self._picture


def find_true(picture: Picture, phrase: str, want: str) -> PhraseEvidence:
    """Return where a phrase is in a picture, known for certain; the largest thing comes first."""
    visible = {one.name: one for one in picture.visible}
    fitting = {name: [*one.names, *one.phrases] for name, one in visible.items()}
    names = PhraseBook(fitting, {}).find(phrase)
    found = [Seen(picture.identity == visible[name].id, 0, 0, 1) for name in names]
    if not found:
        return PhraseEvidence(phrase=phrase, found=False, score=0.0, point=None, boxes=[])
    found.sort(key=lambda part: -part.pixels)
    size = picture.truth.width, picture.truth.height
    return PhraseEvidence(
        phrase=phrase,
        found=True,
        score=1.0,
        point=found[0].point(),
        boxes=[part.box() for part in found],
        heatmap=found[0].heatmap(size) if want == "heatmaps" else None,
    )


@contextmanager
def open_stage(*, model: str, boxes: Boxes, seed: int) -> Iterator[Stage]:
    """Yield a stage with a language model and, for `model` boxes, a vision model.

    Args:
        model: GGUF file of the language model; "" = the embedded one.
        boxes: Who finds things.
        seed: Of the models' answers.

    Raises:
        W2CError: a model cannot be loaded.
    """
    hub = InProcessHub()
    with ExitStack() as stack:
        chosen = ["language"] + (["grounding"] if boxes == "model" else [])
        for name in chosen:
            flags = {"model": model, "deadline": PATIENCE_S} if name == "language" else {}
            config = library(f"{name}_service_config")(robot="test", **flags)
            bus = hub.connect("llm" if name == "language" else name)
            stack.callback(bus.close)
            service = library(f"{name}_service")(config, bus, RealClock())
            stack.callback(service.close)
            service.configure()
        stage = Stage(hub, seed=seed, boxes=boxes)
        stack.callback(stage.close)
        yield stage
