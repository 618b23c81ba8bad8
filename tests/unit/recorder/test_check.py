"""A recording is held against limits, each with its figure."""

from pathlib import Path

import pytest

from support.sessions import Session, status
from w2c import messages as m
from w2c import topics
from w2c.errors import ConfigError
from w2c_recorder.budget import Budget, CallLimits, StreamLimits, read_budget
from w2c_recorder.check import Finding, findings, measure
from w2c_recorder.commands import recording
from w2c_recorder.reading import Recording

STATUS = "state/controller/status"


def figures_of(path: Path, budget: Budget) -> dict[tuple[str, str], Finding]:
    found = findings(measure(Recording(path)), budget)
    return {(finding.subject, finding.figure): finding for finding in found}


@pytest.fixture
def twenty_hertz(tmp_path: Path) -> Path:
    """The controller's status at 20 Hz for a second, with 50 ms more before the sixth."""
    session = Session()
    for number in range(20):
        late = 0.05 if number >= 5 else 0.0
        session.add(0.05 * number + late, topics.CONTROLLER_STATUS, status("hold"))
    return session.write(tmp_path / "a.mcap")


def test_a_rate_is_held_against_a_share_of_the_nominal_one(twenty_hertz: Path) -> None:
    rate = figures_of(twenty_hertz, Budget())[STATUS, "rate"]

    assert rate.value == pytest.approx(19.0)
    assert (rate.limit, rate.kept) == (16.0, True)
    strict = Budget(streams={STATUS: StreamLimits(rate_min=0.99)})
    assert not figures_of(twenty_hertz, strict)[STATUS, "rate"].kept


def test_gaps_jitter_and_silence_are_measured(twenty_hertz: Path) -> None:
    limits = StreamLimits(
        gap_max_ms=60.0, jitter_p99_max_ms=100.0, silent_end_max_s=0.1, age_p99_max_ms=1e15
    )
    found = figures_of(twenty_hertz, Budget(streams={STATUS: limits}))

    assert found[STATUS, "longest gap"].value == pytest.approx(100.0)
    assert not found[STATUS, "longest gap"].kept
    assert 0.0 < found[STATUS, "jitter p99"].value <= 50.0
    assert found[STATUS, "silent at the end"].value == 0.0
    assert found[STATUS, "age p99"].unit == "ms"


def test_losses_are_found(tmp_path: Path) -> None:
    session = Session()
    for number in range(6):
        session.add(0.05 * number, topics.CONTROLLER_STATUS, status("hold"))
    del session.raw[2:4]
    lost = figures_of(session.write(tmp_path / "a.mcap"), Budget())[STATUS, "lost"]

    assert (lost.value, lost.kept) == (2.0, False)


def test_failed_and_slow_calls_are_found(tmp_path: Path) -> None:
    session = Session()
    request, reply = m.MarkRequest(text="x"), m.StopReply(mode="stopped", stamp_ns=0)
    for number, outcome in enumerate(("ok", "deadline", "refused")):
        session.call(
            0.1 * number, topics.ROBOT_STOP, request, reply, outcome=outcome, duration_ms=80.0
        )
    budget = Budget(calls={"robot/stop": CallLimits(p95_max_ms=50.0)})
    found = figures_of(session.write(tmp_path / "a.mcap"), budget)

    assert found["robot/stop", "failed"].value == 1.0
    assert found["robot/stop", "duration p95"].value == pytest.approx(80.0)
    assert not found["robot/stop", "duration p95"].kept


def test_a_stream_that_is_limited_and_missing_fails(twenty_hertz: Path) -> None:
    budget = Budget(streams={"obs/camera/rgbd": StreamLimits(lost_max=0)})

    assert not figures_of(twenty_hertz, budget)["obs/camera/rgbd", "messages"].kept


def test_the_command_fails_beyond_a_limit_of_the_file(
    twenty_hertz: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert recording(["check", str(twenty_hertz)]) == 0
    budget = tmp_path / "budget.toml"
    budget.write_text(f'[streams."{STATUS}"]\ngap_max_ms = 60\n')

    assert recording(["check", str(twenty_hertz), "--budget", str(budget)]) == 1

    printed = capsys.readouterr().out
    assert f"FAIL {STATUS}" in printed
    assert "longest gap        100 ms, limit 60 ms" in printed


def test_a_budget_with_a_wrong_name_says_which_there_are(tmp_path: Path) -> None:
    budget = tmp_path / "budget.toml"
    budget.write_text("[stream]\nspeed = 1\n")

    with pytest.raises(ConfigError, match="unknown field `speed`"):
        read_budget(budget)


def test_a_budget_for_a_call_that_there_is_not_says_which_there_are(tmp_path: Path) -> None:
    """A limit that nothing is held against would be kept for ever."""
    budget = tmp_path / "budget.toml"
    budget.write_text('[calls."llm/complet"]\nfailed_max = 0\n')

    with pytest.raises(ConfigError, match=r"no call 'llm/complet'.*llm/complete"):
        read_budget(budget)
