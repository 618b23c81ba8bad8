"""A training ends at its next step when it is asked to, and says how to go on."""

import shlex
import signal

import pytest

from w2c.config import parse
from w2c_grounding.train.commands import PROGRAM, TrainConfig
from w2c_grounding.train.interruption import continuation, interruptible


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_is_noted_once_and_the_next_one_is_as_without(number: signal.Signals) -> None:
    before = signal.signal(number, signal.SIG_IGN)
    try:
        with interruptible() as stopped:
            assert not stopped()
            signal.raise_signal(number)
            assert stopped()
            assert signal.getsignal(number) is signal.SIG_IGN
    finally:
        signal.signal(number, before)


def test_what_is_told_goes_on_with_the_same_training() -> None:
    flags = [
        "--data", "my pictures", "--out", "out", "--from", "a", "--seed", "3", "--minutes", "7",
    ]  # fmt: skip
    told = continuation(PROGRAM, flags)
    assert told.startswith(f"stopped; go on with: {PROGRAM} ")
    again = shlex.split(told.split(PROGRAM, 1)[1])
    assert again == [*flags, "--resume"]
    config = parse(TrainConfig, again, program=PROGRAM)
    assert (config.data, config.seed, config.minutes, config.resume) == (
        "my pictures",
        3,
        7.0,
        True,
    )


def test_who_resumes_a_resumed_training_is_told_so_once() -> None:
    assert continuation(PROGRAM, ["--resume", "--out", "o"]).count("--resume") == 1
