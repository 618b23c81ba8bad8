"""Every message travels, and bytes on the wire do not change by accident.

To accept a change of the contract: python -m pytest tests/unit/w2c/test_messages.py --accept-golden
"""

import inspect
import json
from pathlib import Path

import numpy as np
import pytest

from support.examples import all_examples
from w2c import messages as m
from w2c import topics
from w2c.bus.codec import decode_message, encode_message
from w2c.errors import MessageError

GOLDEN = Path(__file__).parents[2] / "data" / "golden_messages.json"
EXAMPLES = all_examples()


def test_there_is_an_example_of_every_message() -> None:
    types = {
        name for name, value in vars(m).items()
        if inspect.isclass(value) and issubclass(value, m.Message) and value is not m.Message
    }  # fmt: skip
    assert types == set(EXAMPLES)


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_a_message_survives_the_wire(name: str) -> None:
    payload = encode_message(EXAMPLES[name])
    again = decode_message(payload, type(EXAMPLES[name]))
    assert encode_message(again) == payload


def test_bytes_on_the_wire_are_the_golden_ones(request: pytest.FixtureRequest) -> None:
    found = {name: encode_message(example).hex() for name, example in sorted(EXAMPLES.items())}
    if request.config.getoption("--accept-golden"):
        GOLDEN.write_text(json.dumps(found, indent=1) + "\n")
    assert found == json.loads(GOLDEN.read_text())


def test_the_registry_uses_only_messages_with_an_example() -> None:
    used = {topic.message.__name__ for topic in topics.TOPICS}
    used |= {kind.__name__ for method in topics.METHODS for kind in (method.request, method.reply)}
    assert used <= set(EXAMPLES)


def refused(message: m.Message, **changes: object) -> str:
    """Return the error of the message with these fields changed on the wire."""
    fields = {name: getattr(message, name) for name in message.__struct_fields__}
    import msgpack

    from w2c.bus.codec import _pack_default

    payload = msgpack.packb({**fields, **changes}, default=_pack_default)
    with pytest.raises(MessageError) as error:
        decode_message(payload, type(message))
    return str(error.value)


def test_a_command_with_nan_is_refused() -> None:
    assert "NaN" in refused(EXAMPLES["JointCommand"], position=np.array([0.0, np.nan]))


def test_a_command_of_the_wrong_dtype_is_refused() -> None:
    assert "float32" in refused(EXAMPLES["JointCommand"], position=np.zeros(3, np.float32))


def test_a_goal_without_direction_is_refused_with_its_length() -> None:
    assert "length 0" in refused(EXAMPLES["PlaceGoal"], normal=np.zeros(3))


def test_a_goal_in_millimetres_is_refused() -> None:
    assert "limit 10 m" in refused(EXAMPLES["PlaceGoal"], point=np.array([460.0, -250.0, 840.0]))


def test_an_unknown_end_effector_is_refused() -> None:
    assert "end_effector" in refused(EXAMPLES["PlaceGoal"], end_effector="tail")


def test_an_unknown_field_is_refused() -> None:
    assert "unknown field `fricton`" in refused(EXAMPLES["StopRequest"], fricton=1)


def test_an_utterance_without_end_is_refused() -> None:
    assert "text" in refused(EXAMPLES["SayRequest"], text="a" * 501)


def test_a_state_with_nan_arrives_because_the_receiver_must_judge_it() -> None:
    state = EXAMPLES["RobotState"]
    assert isinstance(state, m.RobotState)
    fields = {name: getattr(state, name) for name in state.__struct_fields__}
    broken = m.RobotState(**{**fields, "position": np.array([np.nan, 0.0, 0.0])})
    again = decode_message(encode_message(broken), m.RobotState)
    assert np.isnan(again.position[0])


@pytest.mark.parametrize(
    ("heights", "complaint"),
    [
        (np.zeros((2, 2)), "float32"),
        (np.zeros((1000, 1000), np.float32), "1000000 cells"),
        (np.full((2, 2), 750.0, np.float32), "beyond 10 m"),
        (np.full((2, 2), np.inf, np.float32), "beyond 10 m"),
    ],
)
def test_a_height_field_that_no_room_has_is_refused(heights: m.Array, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        m.HeightField(stamp_ns=1, origin=(0.0, 0.0), cell=0.02, heights=heights)
