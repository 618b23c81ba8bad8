"""The set-up on a machine that lacks something, and may not install it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from support.documents import ROOT

TOOLS = ("bash", "sed", "id", "grep", "uname", "ls", "dirname", "cat")


def run_setup(tmp_path: Path, python: str) -> "subprocess.CompletedProcess[str]":
    """Run the script with a PATH that holds a few tools only: no g++, no apt-get, no sudo."""
    tools = tmp_path / "bin"
    tools.mkdir()
    for name in TOOLS:
        found = shutil.which(name)
        assert found is not None, name
        (tools / name).symlink_to(found)
    environment = {**os.environ, "PATH": str(tools), "PYTHON": python}
    return subprocess.run(
        ["bash", str(ROOT / "deploy" / "setup.sh")],
        cwd=ROOT,
        env={**environment, "VENV": str(tmp_path / "venv")},
        capture_output=True,
        text=True,
        check=False,
    )


def test_missing_packages_are_named_with_the_command_that_installs_them(tmp_path: Path) -> None:
    answer = run_setup(tmp_path, sys.executable)
    assert answer.returncode == 2
    assert "sudo apt-get update && sudo apt-get install -y g++" in answer.stderr
    assert not (tmp_path / "venv").exists()


def test_an_unsuitable_python_is_named(tmp_path: Path) -> None:
    answer = run_setup(tmp_path, "/nowhere/python")
    assert answer.returncode == 2
    assert "Python 3.11 or newer is needed" in answer.stderr
