"""Requests wait in one queue; those about one picture are answered together."""

import gc
import threading
import weakref
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor

import pytest

from support.waiting import wait_until
from w2c.clock import RealClock, StepClock
from w2c.errors import DeadlineError, RefusedError, UnavailableError
from w2c.messages import GroundingReply, GroundingRequest, PhraseEvidence
from w2c_grounding.batches import MAX_PHRASES, Answered, BatchQueue
from w2c_grounding.together import ground_together


def request(picture: str, *phrases: str, want: str = "boxes") -> GroundingRequest:
    return GroundingRequest(jpeg=picture.encode(), phrases=list(phrases), want=want)  # type: ignore[arg-type]


class Model:
    """Answers a request when it is let; notes what it was asked together."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, list[str], str]] = []
        self.may_answer = threading.Event()
        self.may_answer.set()
        self.began = threading.Semaphore(0)

    def ground(self, request: GroundingRequest) -> GroundingReply:
        self.asked.append((request.jpeg.decode(), request.phrases, request.want))
        self.began.release()
        assert self.may_answer.wait(20.0)
        if "bad" in request.phrases:
            raise RefusedError("a bad phrase")
        if "crash" in request.phrases:
            raise ZeroDivisionError
        evidence = [
            PhraseEvidence(phrase=p, found=True, score=0.5, point=None, boxes=[])
            for p in request.phrases
        ]
        return GroundingReply(model="m", width=4, height=3, evidence=evidence, milliseconds=1.0)


class Desk:
    """A queue before a model, and people who ask at the same time."""

    def __init__(self, limit: int = 8, clock: RealClock | StepClock | None = None) -> None:
        self.model = Model()
        self.queue = BatchQueue(
            lambda requests: ground_together(self.model, requests),
            limit=limit,
            patience_s=60.0,
            clock=clock or RealClock(),
        )
        self.queue.start()
        self._people = ThreadPoolExecutor(20)

    def ask(self, *asked: GroundingRequest) -> list["Future[Answered]"]:
        """Ask one after the other, each while the ones before wait."""
        futures = []
        for one in asked:
            before = self.queue.waiting
            futures.append(self._people.submit(self.queue.ask, one))
            wait_until(lambda before=before: self.queue.waiting > before)  # type: ignore[misc]
        return futures

    def begin(self, one: GroundingRequest) -> "Future[Answered]":
        """Ask, and wait until the model works on it; it goes on working."""
        self.model.may_answer.clear()
        future = self._people.submit(self.queue.ask, one)
        assert self.model.began.acquire(timeout=20.0)
        return future

    def close(self) -> None:
        self.model.may_answer.set()
        self.queue.close()
        self._people.shutdown()


@pytest.fixture
def desk() -> Iterator[Desk]:
    desk = Desk()
    yield desk
    desk.close()


def phrases_of(future: "Future[Answered]") -> list[str]:
    return [one.phrase for one in future.result(20.0).reply.evidence]


def test_requests_about_a_picture_that_wait_are_answered_in_one_go(desk: Desk) -> None:
    first = desk.begin(request("a", "cup"))
    others = desk.ask(
        request("b", "cup", "book"), request("c", "cup"), request("b", "book", "red cup")
    )
    desk.model.may_answer.set()
    assert phrases_of(first) == ["cup"]
    assert [phrases_of(future) for future in others] == [
        ["cup", "book"],
        ["cup"],
        ["book", "red cup"],
    ]
    assert [future.result().together for future in others] == [2, 1, 2]
    assert desk.model.asked == [
        ("a", ["cup"], "boxes"),
        ("b", ["cup", "book", "red cup"], "boxes"),
        ("c", ["cup"], "boxes"),
    ]


def test_one_that_wants_heatmaps_does_not_give_them_to_the_others() -> None:
    import numpy as np

    class WithHeat(Model):
        def ground(self, request: GroundingRequest) -> GroundingReply:
            heat = np.zeros((3, 4), np.uint8)
            evidence = [
                PhraseEvidence(phrase=p, found=False, score=0.0, point=None, boxes=[], heatmap=heat)
                for p in request.phrases
            ]
            return GroundingReply(model="m", width=4, height=3, evidence=evidence, milliseconds=1.0)

    boxes, heat, twice = ground_together(
        WithHeat(),
        [request("a", "cup"), request("a", "cup", want="heatmaps"), request("a", "cup", "cup")],
    )
    assert boxes.evidence[0].heatmap is None
    assert heat.evidence[0].heatmap is not None
    assert [one.phrase for one in twice.evidence] == ["cup", "cup"], "as often as asked"


def test_what_spoils_one_request_spoils_no_other(desk: Desk) -> None:
    desk.begin(request("a", "cup"))
    good, bad, crash = desk.ask(request("b", "cup"), request("b", "bad"), request("b", "crash"))
    desk.model.may_answer.set()
    assert phrases_of(good) == ["cup"]
    with pytest.raises(RefusedError, match="a bad phrase"):
        bad.result(20.0)
    with pytest.raises(ZeroDivisionError):
        crash.result(20.0)


def test_the_thread_outlives_whatever_is_raised(desk: Desk) -> None:
    with pytest.raises(ZeroDivisionError):
        desk.queue.ask(request("a", "crash"))
    assert desk.queue.ask(request("a", "cup")).reply.evidence[0].phrase == "cup"


def test_a_full_queue_says_so_at_once_and_opens_again() -> None:
    desk = Desk(limit=1)
    desk.begin(request("a", "cup"))
    (waiting,) = desk.ask(request("b", "cup"))
    with pytest.raises(UnavailableError, match="1 requests wait, limit 1"):
        desk.queue.ask(request("c", "cup"))
    desk.model.may_answer.set()
    assert phrases_of(waiting) == ["cup"]
    assert desk.queue.ask(request("c", "cup")).together == 1
    desk.close()


def test_many_phrases_are_not_all_asked_at_once(desk: Desk) -> None:
    desk.begin(request("a", "cup"))
    half = [[f"{part} {n}" for n in range(MAX_PHRASES // 2)] for part in "abc"]
    futures = desk.ask(*(request("b", *phrases) for phrases in half))
    desk.model.may_answer.set()
    assert [phrases_of(future) for future in futures] == half
    assert [len(phrases) for _, phrases, _ in desk.model.asked] == [
        1,
        MAX_PHRASES,
        MAX_PHRASES // 2,
    ]


def test_a_request_whose_caller_has_gone_is_not_answered() -> None:
    clock = StepClock()
    desk = Desk(clock=clock)
    first = desk.begin(request("a", "cup"))
    (late,) = desk.ask(request("b", "cup"))
    clock.set(int(61e9))
    desk.model.may_answer.set()
    first.result(20.0)
    with pytest.raises(DeadlineError, match="waited longer than 60 s"):
        late.result(20.0)
    assert len(desk.model.asked) == 1
    desk.close()


def test_an_errand_runs_between_two_requests_and_its_result_is_not_kept(desk: Desk) -> None:
    class Old:
        """Something with a weak reference."""

    first = desk.begin(request("a", "cup"))
    (second,) = desk.ask(request("b", "cup"))
    order: list[str] = []
    with ThreadPoolExecutor(1) as pool:
        errand = pool.submit(desk.queue.between, lambda: order.append(f"{len(desk.model.asked)}"))
        wait_until(lambda: bool(desk.queue._errands))
        desk.model.may_answer.set()
        errand.result(20.0)
    first.result(20.0)
    second.result(20.0)
    assert order == ["1"], "after the first and before the second"

    kept = [Old()]
    reference = weakref.ref(kept[0])
    desk.queue.between(kept.pop)
    wait_until(lambda: gc.collect() >= 0 and reference() is None)


def test_an_errand_that_fails_fails_for_who_sent_it(desk: Desk) -> None:
    with pytest.raises(ZeroDivisionError):
        desk.queue.between(lambda: 1 // 0)
    assert desk.queue.ask(request("a", "cup")).together == 1


def test_closing_finishes_what_runs_and_refuses_what_waits(desk: Desk) -> None:
    first = desk.begin(request("a", "cup"))
    (waiting,) = desk.ask(request("b", "cup"))
    closing = threading.Thread(target=desk.queue.close)
    closing.start()
    with pytest.raises(UnavailableError, match="shut down"):
        waiting.result(20.0)
    desk.model.may_answer.set()
    assert phrases_of(first) == ["cup"]
    closing.join()
    with pytest.raises(UnavailableError, match="shutting down"):
        desk.queue.ask(request("a", "cup"))
    with pytest.raises(UnavailableError, match="shutting down"):
        desk.queue.between(list)
