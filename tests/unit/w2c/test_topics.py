"""The registry is consistent."""

import pytest

from w2c import topics
from w2c.errors import ConfigError


def test_keys_are_unique() -> None:
    keys = [topic.key("talos") for topic in topics.TOPICS]
    assert len(set(keys)) == len(keys)


def test_methods_are_unique() -> None:
    keys = [method.key("talos") for method in topics.METHODS]
    assert len(set(keys)) == len(keys)


@pytest.mark.parametrize("topic", topics.TOPICS, ids=lambda t: f"{t.kind}/{t.service}/{t.name}")
def test_every_key_leads_back_to_its_row(topic: topics.Topic) -> None:  # type: ignore[type-arg]
    writer = "llm" if topic.service == "*" else topic.service
    assert topics.parse_key(topic.key("talos", writer)) == ("talos", topic, writer)


def test_every_key_has_the_form_of_the_contract() -> None:
    for topic in topics.TOPICS:
        parts = topic.key("talos").split("/")
        assert parts[:4] == ["w2c", "v1", "talos", topic.kind]
        assert len(parts) == 6


def test_a_foreign_key_is_refused() -> None:
    with pytest.raises(ConfigError, match="not a key"):
        topics.parse_key("ros/topic")


def test_an_unknown_key_names_the_known_ones() -> None:
    with pytest.raises(ConfigError, match="state/robot/joints"):
        topics.parse_key("w2c/v1/talos/state/robot/joint")


def test_truth_is_for_the_simulator_and_its_judges() -> None:
    for topic in topics.TOPICS:
        if topic.kind == "truth":
            assert set(topic.readers) <= {"camera", "evaluation"}


def test_commands_are_written_by_the_controller_alone() -> None:
    assert {topic.service for topic in topics.TOPICS if topic.kind == "cmd"} == {"controller"}


def test_what_only_a_simulator_has_says_so() -> None:
    """A driver of a real robot need not serve it, and nothing of the product may need it."""
    streams = {f"{topic.kind}/{topic.service}" for topic in topics.TOPICS if topic.simulated}
    calls = {f"{method.service}/{method.name}" for method in topics.METHODS if method.simulated}
    assert streams == {"truth/robot"}
    assert calls == {"robot/push", "camera/picture"}


def test_only_judges_push_the_robot() -> None:
    assert topics.PUSH.callers == ("evaluation",)
