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
    ("text", "limb"),
    [
        ("your right hand is full, so the other one on the rail", "left_hand"),
        ("don't use your right hand, push the gate with the other", "left_hand"),
        ("not the left hand, the right one: grab the jar", "right_hand"),
        ("keep your left foot there and step on it with the other foot", "right_foot"),
        ("tap the crate, not with your right hand but the other one", "left_hand"),
        ("not left foot, right hand, on the balloon", "right_hand"),
    ],
)
def test_a_limb_may_be_told_by_the_other_one(text: str, limb: str) -> None:
    assert named_limb(parse(text)) == limb


@pytest.mark.parametrize(
    "text",
    [
        "take the cup on the left",
        "put a hand on the book",
        "your left hand or your right hand on the box",
        "not the left hand",
        "put your left foot, sorry, hand on the box",
        "keep the right foot on the lino, otherwise it curls",
        "the other mug with a hand, not the left one",
        "not the left mug, the right one",
        "don't use your right hand",
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
