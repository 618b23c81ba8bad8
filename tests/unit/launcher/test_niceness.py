"""A process that can wait is as nice as it should be, whatever the kernel offers."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from w2c_launcher import niceness


class Nices:
    """Stands in for `os.nice`, which cannot be taken back."""

    def __init__(self) -> None:
        self.sum = 0

    def __call__(self, increment: int) -> int:
        self.sum += increment
        return self.sum


class BusyGroup:
    """A kernel that took a wish just now, and takes this one the third time."""

    def __init__(self) -> None:
        self.asked: list[str] = []

    def write_text(self, text: str) -> int:
        self.asked.append(text)
        if len(self.asked) < 3:
            raise OSError(errno.EAGAIN, "Resource temporarily unavailable")
        return len(text)


@pytest.fixture
def nices(monkeypatch: pytest.MonkeyPatch) -> Nices:
    found = Nices()
    monkeypatch.setattr(os, "nice", found)
    monkeypatch.setattr(niceness, "_PAUSE_S", 0.0)
    return found


def test_a_process_becomes_nice_and_stays_so_in_what_it_starts() -> None:
    code = (
        "from w2c_launcher.niceness import give_way; import os; give_way(4);"
        "os.execvp('nice', ['nice'])"
    )

    answer = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        start_new_session=True,
    )

    assert int(answer.stdout) == os.nice(0) + 4


def test_the_session_is_as_nice(nices: Nices, tmp_path: Path) -> None:
    group = tmp_path / "autogroup"
    group.write_text("/autogroup-1 nice 0")

    niceness.give_way(5, group)

    assert (nices.sum, group.read_text()) == (5, "5")


def test_a_kernel_that_is_busy_is_asked_again(nices: Nices) -> None:
    group = BusyGroup()

    niceness.give_way(5, group)  # type: ignore[arg-type]  # one method of a path is all it calls

    assert group.asked == ["5", "5", "5"]


def test_a_kernel_without_session_groups_knows_the_process_only(
    nices: Nices, tmp_path: Path
) -> None:
    niceness.give_way(5, tmp_path / "none" / "autogroup")

    assert nices.sum == 5


def test_a_group_that_is_kept_from_us_is_no_trouble(nices: Nices, tmp_path: Path) -> None:
    niceness.give_way(5, tmp_path)  # a directory: EISDIR, as a container's EACCES

    assert nices.sum == 5


def test_who_goes_first_asks_for_nothing(nices: Nices, tmp_path: Path) -> None:
    niceness.give_way(0, tmp_path / "autogroup")

    assert (nices.sum, list(tmp_path.iterdir())) == (0, [])
