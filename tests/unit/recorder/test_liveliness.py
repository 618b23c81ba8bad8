"""Comings and goings are told once."""

from w2c_recorder.liveliness import Liveliness, LivelinessWatch, is_liveliness_key, key_of


def told(watch: LivelinessWatch, *alive: tuple[str, str]) -> list[tuple[str, str, bool]]:
    return [(c.service, c.instance, c.alive) for c in watch.changes(alive)]


def test_first_look_tells_all_and_the_second_nothing() -> None:
    watch = LivelinessWatch()

    assert told(watch, ("llm", "0"), ("camera", "0")) == [
        ("camera", "0", True),
        ("llm", "0", True),
    ]
    assert told(watch, ("llm", "0"), ("camera", "0")) == []


def test_departures_come_before_arrivals() -> None:
    watch = LivelinessWatch()
    told(watch, ("llm", "0"))

    assert told(watch, ("llm", "1")) == [("llm", "0", False), ("llm", "1", True)]


def test_the_key_is_that_of_the_token() -> None:
    key = key_of("talos", Liveliness(service="llm", instance="0", alive=True))

    assert key == "w2c/v1/talos/live/llm/0"
    assert is_liveliness_key(key)
    assert not is_liveliness_key("w2c/v1/talos/state/robot/joints")
