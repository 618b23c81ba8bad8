"""The process on the bus."""

import io
import threading
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from w2c import topics
from w2c.bus import InProcessHub
from w2c.clock import RealClock
from w2c.errors import ModelError, RefusedError, UnavailableError
from w2c.messages import GroundingRequest
from w2c_grounding.config import Config
from w2c_grounding.node import GroundingNode


def jpeg() -> bytes:
    buffer = io.BytesIO()
    noise = np.random.default_rng(0).integers(0, 255, (72, 128, 3), dtype=np.uint8)
    Image.fromarray(noise).save(buffer, format="JPEG")
    return buffer.getvalue()


def node_of(hub: InProcessHub, **flags: object) -> GroundingNode:
    config = Config(robot="test", threads=1, **flags)  # type: ignore[arg-type]
    return GroundingNode(config, hub.connect("grounding"), RealClock())


def test_it_answers_on_the_bus(tiny_checkpoint: Path) -> None:
    hub = InProcessHub()
    node = node_of(hub, model=str(tiny_checkpoint))
    node.configure()
    request = GroundingRequest(jpeg=jpeg(), phrases=["book", "zebra"], want="heatmaps")
    reply = hub.connect("dialogue").call(topics.GROUND, request).message
    assert reply.model == "tiny"
    assert (reply.width, reply.height) == (128, 72)
    assert [answer.unknown_words for answer in reply.evidence] == [[], ["zebra"]]
    for answer in reply.evidence:
        assert answer.heatmap is not None
        assert answer.heatmap.shape == (72, 128)
    node.close()


def test_the_same_request_gets_the_same_answer_from_another_replica(tiny_checkpoint: Path) -> None:
    request = GroundingRequest(jpeg=jpeg(), phrases=["book"], want="boxes")
    points = []
    for _ in range(2):
        hub = InProcessHub()
        node = node_of(hub, model=str(tiny_checkpoint))
        node.configure()
        points.append(hub.connect("dialogue").call(topics.GROUND, request).message.evidence[0])
        node.close()
    assert points[0].point == points[1].point
    assert points[0].score == points[1].score


def test_a_bad_picture_is_refused_and_the_next_one_answered(tiny_checkpoint: Path) -> None:
    hub = InProcessHub()
    node = node_of(hub, model=str(tiny_checkpoint))
    node.configure()
    caller = hub.connect("dialogue")
    with pytest.raises(RefusedError, match="neither JPEG nor PNG"):
        caller.call(topics.GROUND, GroundingRequest(jpeg=b"junk", phrases=["book"], want="boxes"))
    good = GroundingRequest(jpeg=jpeg(), phrases=["book"], want="boxes")
    assert caller.call(topics.GROUND, good).message.evidence
    node.close()


def test_after_closing_it_says_so(tiny_checkpoint: Path) -> None:
    hub = InProcessHub()
    node = node_of(hub, model=str(tiny_checkpoint))
    node.configure()
    node.close()
    request = GroundingRequest(jpeg=jpeg(), phrases=["book"], want="boxes")
    with pytest.raises(UnavailableError, match="shutting down"):
        hub.connect("dialogue").call(topics.GROUND, request)


def test_a_missing_model_fails_at_configure_before_anything_is_served() -> None:
    hub = InProcessHub()
    node = node_of(hub, model="/nowhere/model")
    with pytest.raises(ModelError, match="/nowhere/model"):
        node.configure()
    assert hub.served == {}
    node.close()


def test_run_ends_when_told() -> None:
    node = node_of(InProcessHub())
    stop = threading.Event()
    worker = threading.Thread(target=node.run, args=(stop,))
    worker.start()
    stop.set()
    worker.join(timeout=5.0)
    assert not worker.is_alive()
