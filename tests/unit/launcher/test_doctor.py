"""What `w2c doctor` says of precedence for the loops."""

import os

import pytest

from w2c_launcher.doctor import Finding, examine


def _precedence(monkeypatch: pytest.MonkeyPatch, *, cores: int, refused: bool = False) -> Finding:
    """Return the finding on a host with so many cores."""

    def schedule(_pid: int, _policy: int, _parameter: os.sched_param) -> None:
        if refused:
            raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", schedule)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _pid: set(range(cores)))
    return next(finding for finding in examine() if finding.subject == "SCHED_FIFO")


def test_precedence_is_granted_and_asked_for_on_enough_cores(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert _precedence(monkeypatch, cores=4) == Finding("SCHED_FIFO", True, "granted")


def test_on_few_cores_it_says_that_nobody_asks_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    found = _precedence(monkeypatch, cores=2)
    assert found.ok
    assert "2 cores not asked for (4 are enough)" in found.text
    assert "--real-time on" in found.text


def test_a_refusal_is_no_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    found = _precedence(monkeypatch, cores=8, refused=True)
    assert not found.ok
    assert found.optional
    assert "Operation not permitted" in found.text
