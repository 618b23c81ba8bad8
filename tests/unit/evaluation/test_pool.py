"""Results are on disk as they come, and a study that was killed goes on."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from w2c.errors import ConfigError, W2CError
from w2c_evaluation.pool import ResultFile, run_all
from w2c_evaluation.results import write_text
from w2c_evaluation.robustness.grid import Target

QUESTION = {"seed": 0, "stiffness": 1.0}


def target(trial: int) -> Target:
    return Target(
        trial=trial, mass=2.0, start=(0.0, 0.0, 1.0), point=(0.5, 0.0, 1.0), direction=(1, 0, 0)
    )


def results(path: Path, question: dict[str, float] | None = None) -> ResultFile[Target]:
    return ResultFile(path, question or QUESTION, Target)


def test_what_was_added_is_there_again(tmp_path: Path) -> None:
    file = results(tmp_path / "new" / "trials.jsonl")
    assert file.start(resume=True) == []
    file.add(target(0))
    file.add(target(1))
    assert results(tmp_path / "new" / "trials.jsonl").start(resume=True) == [target(0), target(1)]


def test_without_resume_it_begins_anew(tmp_path: Path) -> None:
    file = results(tmp_path / "t.jsonl")
    file.start(resume=False)
    file.add(target(0))
    assert results(tmp_path / "t.jsonl").start(resume=False) == []
    assert results(tmp_path / "t.jsonl").start(resume=True) == []


def test_a_line_that_a_kill_cut_short_is_dropped_and_written_again(tmp_path: Path) -> None:
    path = tmp_path / "t.jsonl"
    file = results(path)
    file.start(resume=False)
    file.add(target(0))
    file.add(target(1))
    path.write_bytes(path.read_bytes()[:-7])
    again = results(path)
    assert again.start(resume=True) == [target(0)]
    again.add(target(1))
    assert results(path).start(resume=True) == [target(0), target(1)]


def test_another_question_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "t.jsonl"
    results(path).start(resume=False)
    with pytest.raises(ConfigError, match=r"answers .*'stiffness': 1.0.* asks .*0.7"):
        results(path, {"seed": 0, "stiffness": 0.7}).start(resume=True)


def test_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "t.jsonl"
    path.write_text("no json\nat all\n")
    with pytest.raises(ConfigError, match="no file of results"):
        results(path).start(resume=True)


def test_every_task_gives_its_result_in_processes_of_their_own() -> None:
    found = list(run_all(divmod, [(n, 3) for n in range(7)], workers=2, title="t", show=False))
    assert sorted(found) == sorted(divmod(n, 3) for n in range(7))


def test_nothing_to_do_starts_nothing() -> None:
    assert list(run_all(divmod, [], workers=2, title="t", show=False)) == []


def test_an_error_of_a_trial_is_not_swallowed() -> None:
    with pytest.raises(ZeroDivisionError):
        list(run_all(divmod, [(1, 0)], workers=1, title="t", show=False))


def test_killed_in_the_middle_it_keeps_what_was_done(tmp_path: Path) -> None:
    """A study of sleeping trials is killed as a whole; half of it is on disk."""
    path = tmp_path / "t.jsonl"
    program = tmp_path / "study.py"
    program.write_text(
        "import time\n"
        "from pathlib import Path\n"
        "from w2c_evaluation.pool import ResultFile, run_all\n"
        "if __name__ == '__main__':\n"
        f"    file = ResultFile(Path({str(path)!r}), {QUESTION!r}, float)\n"
        "    file.start(resume=False)\n"
        "    tasks = [(0.05,)] * 3 + [(60.0,)]\n"
        "    for _ in run_all(time.sleep, tasks, workers=1, title='t', show=False):\n"
        "        file.add(1.0)\n"
    )
    study = subprocess.Popen([sys.executable, str(program)], start_new_session=True)
    try:
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline and not _lines(path) >= 4:
            time.sleep(0.05)
    finally:
        os.killpg(study.pid, signal.SIGKILL)
        study.wait()
    assert ResultFile(path, dict(QUESTION), float).start(resume=True) == [1.0, 1.0, 1.0]


def _lines(path: Path) -> int:
    return path.read_text().count("\n") if path.exists() else 0


def test_a_full_disk_says_how_to_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = results(tmp_path / "t.jsonl")
    file.start(resume=False)

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "open", full)
    with pytest.raises(W2CError, match=r"No space left.*go on with --resume --run-directory /"):
        file.add(target(0))


def test_a_report_makes_its_directory_or_says_why_not(tmp_path: Path) -> None:
    write_text("x", tmp_path / "new" / "of" / "these.md")
    assert (tmp_path / "new" / "of" / "these.md").read_text() == "x"
    with pytest.raises(ConfigError, match=r"below\.md cannot be written: .*choose another file"):
        write_text("x", tmp_path / "new" / "of" / "these.md" / "below.md")
