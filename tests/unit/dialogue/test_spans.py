"""Which words of an utterance may be the name of a thing."""

import json

import llguidance
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from w2c_dialogue.prompts.embedded import EmbeddedPrompts
from w2c_dialogue.prompts.spans import MAX_ENUM, NO_NAMES, naming_spans, spans_schema
from w2c_dialogue.utterance import parse
from w2c_llm.schema import check_schema
from w2c_llm.values import violation


def names(text: str) -> set[str]:
    utterance = parse(text)
    return {" ".join(utterance.folded[a - 1 : b]).rstrip(",") for a, b in naming_spans(utterance)}


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("lean between the book and the red mug", "red mug"),
        ("closer to the thing with the wooden handle", "thing with the wooden handle"),
        ("put it on the left one", "left one"),
        ("next to my charger", "my charger"),
        ("onto the bowl that we cook with", "bowl that we cook with"),
        ("behind the top shelf, please", "top shelf"),
        ("to the mug on the right", "mug on the right"),
        ("a bit nearer to the sponge", "sponge"),
        ("take the thing to hit with using your left hand", "thing to hit with"),
        ("take the thing to hit with with your left hand", "thing to hit with"),
        ("take the thing to hit with your left hand", "thing to hit"),
        ("the bar that i hold on to", "bar that i hold on to"),
        ("press the box with the handle", "box with the handle"),
        ("next to the tap you work with your foot", "tap you work with your foot"),
        ("the doll with the left arm in a sling", "doll with the left arm in a sling"),
    ],
)
def test_what_people_call_a_thing_may_be_a_name(text: str, name: str) -> None:
    assert name in names(text)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("lean between book and turquoise trainer", "and turquoise trainer"),
        ("lean between book and turquoise trainer", "book and"),
        ("on the pink bowl, i think", "pink bowl, i think"),
        ("the left edge of the bowl", "of the bowl"),
        ("on the pink sneaker put your hand", "pink sneaker put"),
        ("your foot on the step, behind the milk", "step, behind the milk"),
        ("not the screen, the shelf", "not the screen"),
        ("touch the thing that opens", "thing that"),
        ("take the thing to hit with using your left hand", "thing to"),
        ("take the thing for hot drinks with your left palm", "thing for hot drinks with"),
        ("reach the thing to hit with with your right hand", "thing to hit with with"),
        ("right of the thing to wear with your left hand", "thing to wear with your left"),
        ("right of the thing to wear with your left hand", "thing to wear with your left hand"),
    ],
)
def test_words_around_a_thing_are_not_part_of_its_name(text: str, name: str) -> None:
    assert name not in names(text)


@pytest.mark.parametrize(
    "text",
    [
        "a bit to the left",
        "further to the right, dear",
        "twice as much in the same direction",
        "back down a touch",
        "a thumb's width up",
        "put your right palm there",
    ],
)
def test_directions_and_amounts_name_nothing(text: str) -> None:
    assert names(text) == set()


def test_where_nothing_can_be_named_the_only_answer_is_none() -> None:
    schema = check_schema(spans_schema(parse("a bit to the left")))
    assert violation([], schema) is None
    assert violation(["0-0"], schema) is not None
    compiled = llguidance.LLMatcher.grammar_from_json_schema(json.dumps(schema))
    assert llguidance.LLMatcher.validate_grammar(compiled) == ""


WORDS = st.sampled_from(["book", "red", "mug", "and", "the", "left", "of", "bit", "one", "it"])


@settings(max_examples=20)
@given(st.lists(WORDS, min_size=1, max_size=55))
def test_the_schema_allows_what_may_be_a_name_and_stays_small(words: list[str]) -> None:
    utterance = parse(" ".join(words))
    spans = naming_spans(utterance)
    question = EmbeddedPrompts().objects(utterance)
    assert question.schema is not None
    schema = check_schema(question.schema)["properties"]["objects"]
    assert len(schema["items"].get("enum", [])) <= MAX_ENUM
    for span in spans:
        assert violation([str(span)], schema) is None
        assert not NO_NAMES.issuperset(words[span[0] - 1 : span[1]])
    for number, word in enumerate(words, 1):
        if word == "and":
            assert violation([f"{number}-{number}"], schema) is not None


@pytest.mark.parametrize(
    "text",
    [
        "take the cardboard cheez it box with your left palm.",
        "touch the cardboard cheez it box",
        "right of the cardboard cheez it box, please",
    ],
)
def test_a_pronoun_has_no_noun_behind_it(text: str) -> None:
    found = names(text)
    assert "cardboard cheez it box" in found
    assert found.isdisjoint({"cardboard cheez", "cheez", "cardboard cheez it"})


@pytest.mark.parametrize(
    "text",
    [
        "grab the cup, it is near",
        "see the cup it is near the door",
        "take the cup it stands by the lamp",
        "the cup, it looks nice",
        "touch the cup it has",
        "you see the cup it",
    ],
)
def test_before_a_pronoun_a_name_may_end(text: str) -> None:
    assert "cup" in names(text)


@pytest.mark.parametrize(
    ("text", "whole"),
    [
        ("lean on the thing to wear", "thing to wear"),
        ("touch that red thing to sit on with your left hand", "red thing to sit on"),
    ],
)
def test_a_thing_is_not_cut_off_from_its_use(text: str, whole: str) -> None:
    assert whole in names(text)
    assert whole.split(" to ", maxsplit=1)[0] not in names(text)


@pytest.mark.parametrize(
    ("text", "whole"),
    [
        ("between the thing that rings and the cup", "thing that rings"),
        ("lean on the thing we baked", "thing we baked"),
        ("beside the thing the baker kneads on", "thing the baker kneads on"),
    ],
)
def test_a_bare_thing_is_not_cut_off_from_what_says_which(text: str, whole: str) -> None:
    assert whole in names(text)
    assert "thing" not in names(text)
    assert "blue thing" in names(text.replace("thing", "blue thing"))


@pytest.mark.parametrize(
    "text",
    [
        "move the red thing to the left",
        "hold the red thing to your right",
        "from the red thing to shelf two",
    ],
)
def test_a_direction_is_no_use(text: str) -> None:
    assert "red thing" in names(text)


@pytest.mark.parametrize(
    ("text", "whole"),
    [
        ("press on the thing to drive nails with", "thing to drive nails with"),
        ("touch the thing to chop vegetables on using your left hand",
         "thing to chop vegetables on"),
        ("reach left from the thing to build with with your left arm", "thing to build with"),
        ("take the thing we put plates in, please", "thing we put plates in"),
        ("left of that stool my aunt sits on", "stool my aunt sits on"),
        ("press on the thing to drive nails with please.", "thing to drive nails with"),
        ("grab the doodah you pull weeds with and give it here", "doodah you pull weeds with"),
    ],
)  # fmt: skip
def test_a_use_keeps_its_preposition(text: str, whole: str) -> None:
    assert whole in names(text)
    assert whole.rsplit(" ", maxsplit=1)[0] not in names(text)


@pytest.mark.parametrize("verb", ["opens", "usually opens"])
def test_a_clause_keeps_what_its_verb_does_it_to(verb: str) -> None:
    text = f"grab the lever that {verb} the gate"
    assert f"lever that {verb} the gate" in names(text)
    assert f"lever that {verb}" not in names(text)
    for amount in ("a bit further", "a bit."):
        assert f"lever that {verb}" in names(f"grab the lever that {verb} {amount}")
    for mark in (",", ";", ".", '."'):
        text = f"the lever that {verb}{mark} the left hand goes there"
        assert f"lever that {verb}" in names(text)


def test_a_clause_is_not_cut_in_its_middle() -> None:
    assert "tool you pull long weeds with" in names("grab the tool you pull long weeds with")
    assert "tool you pull long" not in names("grab the tool you pull long weeds with")


@pytest.mark.parametrize(
    ("text", "whole"),
    [
        ("press the lid of the pot on", "lid of the pot"),
        ("bring the trolley with all the drawers in", "trolley with all the drawers"),
        ("the cloth that covers the loaves, off", "cloth that covers the loaves"),
        ("the mug you like on the left shelf", "mug you like"),
        ("take the thing to dig with your right hand", "thing to dig"),
        ("stand on the thing to drink from on the left", "thing to drink from"),
        ("put the red thing with the other mugs", "red thing"),
        ("the thing to read in front of you", "thing to read"),
    ],
)
def test_a_preposition_that_begins_something_else_is_no_part_of_a_use(
    text: str, whole: str
) -> None:
    assert whole in names(text)
