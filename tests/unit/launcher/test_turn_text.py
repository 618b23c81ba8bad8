"""What the terminal shows of a turn."""

from typing import Any

import numpy as np

from w2c.messages import Target, Turn
from w2c_launcher.turn_text import turn_lines


def turn(**values: Any) -> Turn:
    told: dict[str, Any] = {"stamp_ns": 1, "text": "", "module": "none", "reply": "so be it"}
    return Turn(**{**told, "ok": True, "seconds": 0.1, **values})


def test_a_question_lists_its_answers_and_says_how_to_answer() -> None:
    lines = turn_lines(turn(module="question", reply="Which mug?", options=["left", "right"]))
    assert lines == [
        "[question] Which mug?",
        "  1. left",
        "  2. right",
        'answer in words: w2c say "left"',
    ]


def test_what_is_no_question_asks_for_no_answer() -> None:
    assert turn_lines(turn()) == ["[none] so be it"]


def test_a_target_is_told_with_its_place_and_its_warning() -> None:
    target = Target(
        target_id="target-1",
        frame_stamp_ns=1,
        u=640.4,
        v=360.6,
        point=np.array([0.5, -0.25, 0.8]),
        normal=np.array([0.0, 0.0, 1.0]),
        state="proposed",
        warning="steep",
    )
    assert turn_lines(turn(target=target))[1:] == [
        "target target-1 at pixel (640, 361), in the world (0.500, -0.250, 0.800) m",
        "warning: steep",
    ]
