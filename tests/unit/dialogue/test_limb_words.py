"""A limb that is named with its side, once, is what is meant."""

import pytest

from w2c_dialogue.prompts.base import EFFECTORS
from w2c_dialogue.prompts.embedded import EmbeddedPrompts
from w2c_dialogue.prompts.limb_words import named_limb
from w2c_dialogue.utterance import parse


@pytest.mark.parametrize(
    ("text", "limb"),
    [
        ("put your right hand on the book", "right_hand"),
        ("LEFT palm, flat, on the lid", "left_hand"),
        ("swing the right hoof onto the plank", "right_foot"),
        ("forearm, left, on the ledge", "left_hand"),
        ("left hand on the cup, yes the left hand", "left_hand"),
        ("with your left sole on the right of the box", "left_foot"),
    ],
)
def test_a_limb_with_its_side_is_meant(text: str, limb: str) -> None:
    assert named_limb(parse(text)) == limb


@pytest.mark.parametrize(
    "text",
    [
        "take the cup on the left",
        "put a hand on the book",
        "your left hand or your right hand on the box",
        "not the left hand",
        "put your left foot, sorry, hand on the box",
        "your right hand is full, so the other one on the rail",
        "my left arm hurts, hold me",
        "on the right hand side of the box",
        "stand on the left arm of the sofa",
        "hand, left of the box, on the table",
    ],
)
def test_a_model_must_tell_the_rest(text: str) -> None:
    assert named_limb(parse(text)) is None


@pytest.mark.parametrize(
    ("text", "allowed"),
    [("rest your left elbow there", ["left_hand"]), ("rest an elbow there", list(EFFECTORS))],
)
def test_the_embedded_model_may_answer_nothing_else(text: str, allowed: list[str]) -> None:
    schema = EmbeddedPrompts().effector(parse(text)).schema
    assert schema is not None
    properties = schema["properties"]
    assert isinstance(properties, dict)
    assert properties["effector"]["enum"] == allowed
