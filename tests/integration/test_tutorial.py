"""The tutorial, command by command, as a newcomer types it: real processes, real time."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.documents import ROOT, commands_of
from support.ports import free_endpoint, free_port

TUTORIAL = ROOT / "docs" / "tutorial" / "first-conversation.md"


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Path]:
    """A directory to work in; whatever runs there in the end is stopped."""
    yield tmp_path
    subprocess.run([sys.executable, "-m", "w2c.cli", "down"], cwd=tmp_path, check=False)


def own_ports(words: list[str]) -> list[str]:
    """Return the words; `up` gets ports that no other system uses."""
    if words[1] != "up":
        return words
    return [
        *words, "--router", free_endpoint(), "--robot-endpoint", free_endpoint(),
        "--console-port", str(free_port()),
    ]  # fmt: skip


@pytest.mark.slow
@pytest.mark.real_time
def test_every_command_of_the_tutorial_does_what_it_says(desk: Path) -> None:
    output: dict[str, str] = {}
    for words in commands_of(TUTORIAL):
        if words[0] == "make":  # `make demo` has a test of its own
            continue
        command = own_ports([Path(words[0]).name, *words[1:]])
        assert command[0] == "w2c"
        answer = subprocess.run(
            [sys.executable, "-m", "w2c.cli", *command[1:]],
            cwd=desk,
            capture_output=True,
            text=True,
            check=False,
        )
        shown = " ".join(words)
        assert answer.returncode == 0, f"{shown}\n{answer.stdout}\n{answer.stderr}"
        output[shown] = answer.stdout
    said = [text for command, text in output.items() if " say " in command]
    assert "[prediction.absolute]" in said[0]
    assert "[correction]" in said[1]
    assert "[confirmation]" in said[2]
    assert "loaded" in said[2]
    assert (desk / "book.png").stat().st_size > 10_000
    timeline = output[".venv/bin/w2c recording timeline runs/current/session.mcap"]
    assert "Place your right hand on top of the book" in timeline
    assert "that was my first session" in timeline
