"""Requests become replies."""

import io
from collections.abc import Sequence

import numpy as np
import pytest
from PIL import Image

from fakes.vision import FakeFamily
from w2c.errors import RefusedError
from w2c.messages import GroundingReply, GroundingRequest
from w2c_grounding.answer import Grounder
from w2c_grounding.card import ModelCard
from w2c_grounding.family import Evidence, RgbImage, ScoredBox

CARD = ModelCard(name="fake", threshold=0.5, vocabulary=["red", "blue", "square"])


def squares(red_at: int = 40) -> bytes:
    """Return a JPEG of 320 x 180: a red square of 40 px, its left edge given, and a blue one."""
    image = np.full((180, 320, 3), 128, dtype=np.uint8)
    image[60:100, red_at : red_at + 40] = (255, 0, 0)
    image[20:60, 240:280] = (0, 0, 255)
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, format="JPEG", quality=98, subsampling=0)
    return buffer.getvalue()


def ask(grounder: Grounder, *phrases: str, want: str = "boxes", at: int = 40) -> GroundingReply:
    request = GroundingRequest(jpeg=squares(at), phrases=list(phrases), want=want)  # type: ignore[arg-type]
    return grounder.ground(request)


def test_a_phrase_gets_its_box_and_point_in_pixels_of_the_picture() -> None:
    reply = ask(Grounder(FakeFamily(), CARD), "the red square")
    (answer,) = reply.evidence
    assert (reply.model, reply.width, reply.height) == ("fake", 320, 180)
    assert answer.found
    assert answer.score == pytest.approx(0.9)
    (box,) = answer.boxes
    assert (box.left, box.top, box.right, box.bottom) == pytest.approx((40, 60, 80, 100), abs=2)
    assert answer.point == pytest.approx((60, 80), abs=2)


def test_answers_come_in_the_order_of_the_phrases_with_their_own_words() -> None:
    reply = ask(Grounder(FakeFamily(), CARD), "The BLUE one", "red", "green")
    assert [answer.phrase for answer in reply.evidence] == ["The BLUE one", "red", "green"]
    assert [answer.found for answer in reply.evidence] == [True, True, False]


def test_what_is_not_there_is_an_answer() -> None:
    (answer,) = ask(Grounder(FakeFamily(), CARD), "green square").evidence
    assert not answer.found
    assert answer.boxes == []
    assert answer.point is None


def test_heatmaps_come_only_when_wanted() -> None:
    grounder = Grounder(FakeFamily(), CARD)
    assert ask(grounder, "red").evidence[0].heatmap is None
    heatmap = ask(grounder, "red", want="heatmaps").evidence[0].heatmap
    assert heatmap is not None
    assert heatmap.shape == (180, 320)
    assert heatmap[80, 60] == round(0.9 * 255)
    assert heatmap[10, 10] == 0


def test_words_the_model_never_saw_are_reported() -> None:
    (answer,) = ask(Grounder(FakeFamily(), CARD), "the red flurb").evidence
    assert answer.unknown_words == ["flurb"]


class CountingFamily(FakeFamily):
    """Notes how many phrases it is asked at a time."""

    def __init__(self) -> None:
        super().__init__()
        self.batches: list[int] = []

    def query(self, context: RgbImage, phrases: Sequence[str]) -> list[Evidence]:
        self.batches.append(len(phrases))
        return super().query(context, phrases)


class _Detector(FakeFamily):
    """Gives boxes of its own, among them one that makes no sense; cannot read 'zyx'."""

    def query(self, context: RgbImage, phrases: Sequence[str]) -> list[Evidence]:
        boxes = (
            ScoredBox(100, 10, 120, 40, 0.6),
            ScoredBox(200, 10, 260, 40, 0.9),
            ScoredBox(float("nan"), 0, 1, 1, 0.9),
        )
        heat = np.zeros(context.shape[:2], dtype=np.float32)
        return [Evidence(heat, boxes, ("zyx",) if "zyx" in phrase else ()) for phrase in phrases]


def test_a_detectors_boxes_are_the_answer_best_first_and_nonsense_is_counted() -> None:
    grounder = Grounder(_Detector(), CARD)
    (answer,) = ask(grounder, "red").evidence
    assert [(box.left, box.score) for box in answer.boxes] == [(200, 0.9), (100, 0.6)]
    assert (answer.found, answer.score) == (True, 0.9)
    assert answer.point == pytest.approx((230, 25), abs=1)
    assert grounder.dropped_boxes == 1


def test_words_the_model_cannot_read_are_reported_once_too() -> None:
    for card in (CARD, ModelCard(name="public")):
        (answer,) = ask(Grounder(_Detector(), card), "red zyx").evidence
        assert answer.unknown_words == ["zyx"]


def test_the_same_picture_is_prepared_once() -> None:
    family = FakeFamily()
    grounder = Grounder(family, CARD)
    first = ask(grounder, "red")
    second = ask(grounder, "red", "blue")
    assert family.prepared == 1
    assert first.evidence[0].point == second.evidence[0].point


def test_other_pictures_are_not_confused_and_memory_is_bounded() -> None:
    family = FakeFamily()
    grounder = Grounder(family, CARD)
    for at in (10, 60, 110, 160, 190):
        (answer,) = ask(grounder, "red", at=at).evidence
        assert answer.point == pytest.approx((at + 20, 80), abs=2)
    ask(grounder, "red", at=10)
    assert family.prepared == 6


def test_heat_of_many_phrases_is_not_held_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two pictures' worth of it, here; the answers are the same and in order."""
    monkeypatch.setattr("w2c_grounding.answer.HEAT_AT_ONCE", 2 * 320 * 180)
    family = CountingFamily()
    phrases = ["red", "green", "blue", "red one", "blue one"]
    reply = ask(Grounder(family, CARD), *phrases)
    assert family.batches == [2, 2, 1]
    assert [answer.phrase for answer in reply.evidence] == phrases
    assert [answer.found for answer in reply.evidence] == [True, False, True, True, True]


def test_a_damaged_picture_is_refused() -> None:
    grounder = Grounder(FakeFamily(), CARD)
    with pytest.raises(RefusedError, match="picture"):
        grounder.ground(GroundingRequest(jpeg=b"\xff\xd8 no", phrases=["red"], want="boxes"))


def test_a_phrase_without_words_is_refused_before_the_model_works() -> None:
    family = FakeFamily()
    with pytest.raises(RefusedError, match="no word"):
        ask(Grounder(family, CARD), "red", "???")
    assert family.prepared == 0


def test_the_time_of_an_answer_is_measured_with_the_given_clock() -> None:
    times = iter([1_000_000_000, 1_250_000_000])
    reply = ask(Grounder(FakeFamily(), CARD, timer=lambda: next(times)), "red")
    assert reply.milliseconds == pytest.approx(250.0)
