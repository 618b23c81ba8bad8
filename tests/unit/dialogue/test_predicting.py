"""One instruction about one picture: the same modules, and the step at which it failed."""

from typing import Any

import pytest

from fakes.dialogue_world import KnownThings, ScriptedModel
from w2c.errors import ConfigError, DeadlineError, ModelError, RemoteError, UnavailableError
from w2c_dialogue.batch.predicting import Predicted, Predicting

BOOK, CUP = (100.0, 100.0, 300.0, 200.0), (600.0, 300.0, 700.0, 400.0)
THINGS = {"book": BOOK, "cup": CUP}
ABSOLUTE = {"position": "absolute", "objects": ["4-4"]}
RELATIVE = {"position": "relative", "objects": ["4-4"]}


def predict(text: str = "lean on the book", **changes: Any) -> Predicted:
    answers: dict[str, Any] = {
        "select": ["prediction"],
        "analyze": [ABSOLUTE],
        "relative": [{"x": "a.left-0.5*a.width", "y": "a.v"}],
    }
    grounding = KnownThings(**changes.pop("things", THINGS))
    predicting = Predicting(ScriptedModel(**(answers | changes)), grounding)
    return predicting.predict(text, b"picture", (1280, 720))


def test_on_a_thing_is_the_point_that_grounding_chose() -> None:
    found = predict()

    assert found.point == (200.0, 150.0)
    assert (found.module, found.position, found.phrases) == ("prediction", "absolute", ("book",))
    assert [(box.left, box.bottom) for box in found.boxes] == [(100.0, 200.0)]
    assert (found.failed, found.asks) == ("", False)


def test_relative_to_a_thing_is_the_models_arithmetic_on_its_box_and_at_its_foot() -> None:
    found = predict("left of the cup", analyze=[RELATIVE])

    assert found.point == (550.0, 367.0)
    assert found.position == "relative"


def test_centimetres_are_as_long_as_was_said() -> None:
    model = ScriptedModel(
        select=["prediction"], analyze=[RELATIVE], relative=[{"x": "a.left-5*cm", "y": "a.v"}]
    )
    predicting = Predicting(model, KnownThings(**THINGS))
    found = predicting.predict("left of the cup", b"picture", (1280, 720), 8.0)

    assert found.point == (575.0, 367.0)


@pytest.mark.parametrize(("pixels_per_cm", "u"), [(8.0, 580.0), (2.0, 592.0)])
def test_beside_a_large_thing_is_no_farther_than_a_hand_needs(
    pixels_per_cm: float, u: float
) -> None:
    usual = {"x": "a.left-0.2*a.width", "y": "a.v"}
    model = ScriptedModel(select=["prediction"], analyze=[RELATIVE], relative=[usual])
    predicting = Predicting(model, KnownThings(**THINGS))
    found = predicting.predict("left of the cup", b"picture", (1280, 720), pixels_per_cm)

    assert found.point == (u, 367.0)


def test_of_several_things_the_best_is_taken_and_it_says_so() -> None:
    found = predict(things={"book": [BOOK, CUP]})

    assert found.point == (200.0, 150.0)
    assert found.asks
    assert len(found.boxes) == 1


def test_words_within_a_name_choose_one_of_several() -> None:
    analysis = {"position": "absolute", "objects": ["4-5"]}
    found = predict("lean on the right book", analyze=[analysis],
                    things={"right_book": [BOOK, CUP]})  # fmt: skip

    assert found.point == (650.0, 350.0)
    assert not found.asks


@pytest.mark.parametrize(
    ("changes", "step", "reason"),
    [
        ({"analyze": [{"position": "above", "objects": []}]}, "analyzer", "form"),
        ({"analyze": [{"position": "absolute", "objects": []}]}, "analyzer", "no object"),
        ({"analyze": [ModelError("lost")]}, "analyzer", "lost"),
        ({"analyze": [RemoteError("outside its schema")]}, "analyzer", "schema"),
        ({"analyze": [DeadlineError("late")]}, "analyzer", "late"),
        ({"select": [ModelError("lost")]}, "selector", "lost"),
        ({"things": {"cup": CUP}}, "segmentation", "don't see"),
        ({"things": {"cup": CUP}, "analyze": [RELATIVE]}, "detection", "don't see"),
        ({"analyze": [RELATIVE], "relative": [{"x": "b.u", "y": "1"}]}, "expression", "b.u"),
        ({"text": "a" * 501}, "selector", "501"),
    ],
)
def test_the_step_that_gives_up_is_named(changes: dict[str, Any], step: str, reason: str) -> None:
    found = predict(**changes)

    assert found.point is None
    assert found.failed == step
    assert reason in found.reason


def test_a_service_that_is_gone_is_no_answer() -> None:
    with pytest.raises(UnavailableError):
        predict(analyze=[UnavailableError("nobody")])


def test_an_ablation_of_the_embedded_prompts_is_refused() -> None:
    with pytest.raises(ConfigError, match="--prompts large"):
        Predicting(ScriptedModel(), KnownThings(), ablation="zero_shot")


def test_with_a_single_prompt_the_model_is_asked_once() -> None:
    answer = {"position": "relative", "objects": ["cup"], "x": "a.right+10", "y": "a.v"}
    model = ScriptedModel(analyze=[answer])
    predicting = Predicting(model, KnownThings(**THINGS), prompts="large", ablation="single_prompt")

    found = predicting.predict("right of the cup", b"picture", (1280, 720))

    assert found.point == (710.0, 367.0)
    assert [question.task for question in model.questions] == ["analyze"]
