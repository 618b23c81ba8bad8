"""The process on the bus."""

import gc
import io
import threading
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image

from fakes.vision import FakeFamily
from support.waiting import wait_until
from w2c import topics
from w2c.bus import InProcessBus, InProcessHub
from w2c.clock import RealClock
from w2c.errors import ModelError, RefusedError, RemoteError, UnavailableError
from w2c.messages import GroundingReply, GroundingRequest, UseModelReply, UseModelRequest
from w2c_grounding.card import ModelCard
from w2c_grounding.config import Config
from w2c_grounding.family import Family
from w2c_grounding.guard import Guarded
from w2c_grounding.loaded import another
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.node import GroundingNode
from w2c_grounding.use_command import change_each, describe, replicas_of


def jpeg(seed: int = 0) -> bytes:
    buffer = io.BytesIO()
    noise = np.random.default_rng(seed).integers(0, 255, (72, 128, 3), dtype=np.uint8)
    Image.fromarray(noise).save(buffer, format="JPEG")
    return buffer.getvalue()


def node_of(hub: InProcessHub, instance: str = "0", **flags: object) -> GroundingNode:
    config = Config(robot="test", threads=1, **flags)  # type: ignore[arg-type]
    return GroundingNode(config, hub.connect("grounding", instance=instance), RealClock())


class Shelf:
    """Models by name that are loaded as told; a name that begins with 'broken' cannot be."""

    def __init__(self) -> None:
        self.before_loading: Callable[[], None] = lambda: None
        self.before_query: Callable[[], None] = lambda: None
        self.loaded: list[ModelConfig] = []
        self.families: list[weakref.ref[FakeFamily]] = []

    def load(self, config: ModelConfig) -> tuple[Family[Any], ModelCard]:
        self.before_loading()
        self.loaded.append(config)
        if config.model.startswith("broken"):
            raise ModelError(f"{config.model} is damaged; copy it again")
        family = FakeFamily(self._wait)
        self.families.append(weakref.ref(family))
        return family, ModelCard(name=config.model or "embedded", threshold=0.5)

    def _wait(self) -> None:
        self.before_query()


class Running:
    """A replica of fakes on a hub, and somebody who asks it."""

    def __init__(self, **flags: object) -> None:
        self.hub = InProcessHub()
        self.shelf = Shelf()
        self.bus = self.hub.connect("grounding")
        config = Config(robot="test", **flags)  # type: ignore[arg-type]
        self.node = GroundingNode(config, self.bus, RealClock(), self.shelf.load)
        self.node.configure()
        self.operator: InProcessBus = self.hub.connect("operator")

    def ground(self, *phrases: str, seed: int = 0) -> GroundingReply:
        request = GroundingRequest(jpeg=jpeg(seed), phrases=list(phrases), want="boxes")
        return self.operator.call(topics.GROUND, request, timeout_s=20.0).message

    def use(self, model: str, **more: Any) -> UseModelReply:
        request = UseModelRequest(model=model, **more)
        return self.operator.call(topics.USE_MODEL, request, timeout_s=20.0).message


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


def test_a_bad_picture_is_refused_and_counted_and_the_next_one_answered() -> None:
    running = Running()
    request = GroundingRequest(jpeg=b"junk", phrases=["book"], want="boxes")
    with pytest.raises(RefusedError, match="neither JPEG nor PNG"):
        running.operator.call(topics.GROUND, request)
    assert running.bus.counters["request refused"] == 1
    assert running.ground("red").evidence
    running.node.close()


def test_what_does_not_fit_into_the_queue_is_rejected_and_counted() -> None:
    running = Running(queue_limit=0)
    working, go_on = threading.Event(), threading.Event()

    def wait() -> None:
        working.set()
        assert go_on.wait(20.0)

    running.shelf.before_query = wait
    with ThreadPoolExecutor(1) as pool:
        first = pool.submit(running.ground, "red")
        assert working.wait(20.0)
        with pytest.raises(UnavailableError, match="grounding is busy"):
            running.ground("blue")
        go_on.set()
        assert first.result(20.0).evidence
    assert running.bus.counters["request rejected: queue full or stopping"] == 1
    running.node.close()


def test_health_says_which_model_what_it_takes_and_how_often_pictures_repeat() -> None:
    running = Running()
    assert running.node.detail == "embedded"
    running.ground("red")
    running.ground("blue")
    assert running.node.queue_length == 0
    assert running.node.detail.startswith("embedded; 2 answers, 0 of them with others")
    assert "50 % of pictures known" in running.node.detail
    running.node.close()


def test_another_model_takes_over_and_the_old_one_is_let_go() -> None:
    running = Running(device="cpu", threshold=0.3, template="a {}")
    assert running.ground("red").model == "embedded"
    reply = running.use("second", family="clipseg")
    assert (reply.model, reply.previous, reply.threshold) == ("second", "embedded", 0.5)
    assert running.ground("red").model == "second"
    old, new = running.shelf.families
    wait_until(lambda: gc.collect() >= 0 and old() is None)
    assert new() is not None
    chosen = running.shelf.loaded[1]
    assert (chosen.model, chosen.family, chosen.threshold, chosen.template) == (
        ("second", "clipseg", None, None)
    )
    assert running.use("embedded").previous == "second"
    assert running.shelf.loaded[2].model == ""
    running.node.close()


def test_a_model_at_a_server_is_not_asked_to_warm_up_and_its_connections_are_closed() -> None:
    class AtServer(FakeFamily):
        def __init__(self) -> None:
            super().__init__()
            self.happened: list[str] = []

        def warm_up(self) -> None:
            self.happened.append("warm-up")

        def close(self) -> None:
            self.happened.append("closed")

    remote = AtServer()
    running = Running()
    kept = running.shelf.load
    running.node._load = lambda _: (Guarded(remote, "cpu"), ModelCard(name="far", threshold=0.5))
    assert running.use("far").model == "far"
    assert (remote.happened, remote.asked) == (["warm-up"], [])
    assert running.ground("red").model == "far"
    running.node._load = kept
    running.use("near")
    assert remote.happened == ["warm-up", "closed"]
    running.node.close()


def test_no_request_is_lost_while_a_model_is_exchanged() -> None:
    running = Running(queue_limit=20)
    stop = threading.Event()
    answers: list[list[str]] = [[] for _ in range(3)]

    def ask(number: int) -> None:
        while not stop.is_set():
            answers[number].append(running.ground("red", "blue", seed=number % 2).model)

    def everyone_got(more: int) -> None:
        wanted = [len(models) + more for models in answers]
        wait_until(
            lambda: all(len(a) >= n for a, n in zip(answers, wanted, strict=True)), timeout_s=60.0
        )

    with ThreadPoolExecutor(3) as people:
        asking = [people.submit(ask, number) for number in range(3)]
        for model in ("second", "third"):
            everyone_got(1)
            running.use(model)
        everyone_got(2)
        stop.set()
        for future in asking:
            future.result(20.0)
    for models in answers:
        assert [m for i, m in enumerate(models) if i == 0 or models[i - 1] != m] == [
            "embedded", "second", "third",
        ]  # fmt: skip
    running.node.close()


def test_while_a_model_is_loaded_the_old_one_answers_and_no_other_is_loaded() -> None:
    running = Running()
    loading, go_on = threading.Event(), threading.Event()

    def wait() -> None:
        loading.set()
        assert go_on.wait(20.0)

    running.shelf.before_loading = wait
    with ThreadPoolExecutor(1) as pool:
        changing = pool.submit(running.use, "second")
        assert loading.wait(20.0)
        assert running.ground("red").model == "embedded"
        assert running.node.detail.endswith("loading second")
        with pytest.raises(RefusedError, match="second is being loaded"):
            running.use("third")
        go_on.set()
        assert changing.result(20.0).model == "second"
    assert "loading" not in running.node.detail
    running.node.close()


def test_a_model_that_cannot_be_loaded_changes_nothing() -> None:
    running = Running()
    with pytest.raises(RefusedError, match="broken one is damaged"):
        running.use("broken one")
    assert running.ground("red").model == "embedded"
    assert running.use("second").previous == "embedded", "the next change is possible"
    running.node.close()


def test_each_replica_changes_when_it_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    hub, shelf = InProcessHub(), Shelf()
    nodes = []
    for instance in ("0", "1"):
        bus = hub.connect("grounding", instance=instance)
        node = GroundingNode(Config(robot="test"), bus, RealClock(), shelf.load)
        node.configure()
        nodes.append(node)
    operator = hub.connect("operator")
    assert replicas_of(operator, 1.0) == ["0", "1"]
    change_each(operator, ["1"], "second", "")
    assert [node.detail for node in nodes] == ["embedded", "second"]
    change_each(operator, ["0", "1"], "third", "")
    assert [node.detail for node in nodes] == ["third", "third"]
    printed = capsys.readouterr().out.splitlines()
    assert [line.partition(";")[0] for line in printed] == [
        "grounding 1: second answers now instead of embedded",
        "grounding 0: third answers now instead of embedded",
        "grounding 1: third answers now instead of second",
    ]
    for node in nodes:
        node.close()


def test_without_a_grounding_process_the_verb_says_how_to_start_one() -> None:
    with pytest.raises(UnavailableError, match="w2c grounding"):
        replicas_of(InProcessHub().connect("operator"), 0.0)


def test_what_belongs_to_the_machine_stays_and_what_belonged_to_the_model_goes() -> None:
    config = ModelConfig(
        model="old", revision="v1", device="cuda:1", threads=7, dtype="bfloat16", threshold=0.1,
        template="a {}", input_size=512, allow_download=True,
    )  # fmt: skip
    assert another(config, "new", "") == ModelConfig(
        model="new", device="cuda:1", threads=7, dtype="bfloat16", allow_download=True
    )


def test_the_line_of_a_change_has_what_it_took() -> None:
    reply = UseModelReply(
        model="new", previous="old", threshold=0.25, seconds=2.54, memory_mb=899.6
    )
    assert describe("0", reply) == (
        "grounding 0: new answers now instead of old; threshold 0.25, loaded in 2.5 s, 900 MB"
    )


def test_after_closing_it_says_so() -> None:
    running = Running()
    running.node.close()
    with pytest.raises(UnavailableError, match="shutting down"):
        running.ground("red")
    with pytest.raises(UnavailableError, match="shutting down"):
        running.use("second")


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


def test_it_ends_when_its_gpu_has_failed_and_not_when_a_request_has() -> None:
    running = Running()

    def fail(error: Exception) -> Callable[[], None]:
        def raise_it() -> None:
            raise error

        return raise_it

    running.shelf.before_query = fail(RuntimeError("one bad picture"))
    with pytest.raises(RemoteError):
        running.ground("cup")
    stop = threading.Event()
    threading.Timer(0.5, stop.set).start()
    running.node.run(stop)

    running.shelf.before_query = fail(torch.AcceleratorError("CUDA error: device-side assert"))
    with pytest.raises(RemoteError):
        running.ground("cup")
    with pytest.raises(ModelError, match=r"failed: CUDA error.*started anew"):
        running.node.run(threading.Event())
    running.node.close()
