"""The set-up on a machine that lacks something, and may not install it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from support.documents import ROOT

TOOLS = ("bash", "sed", "id", "grep", "uname", "ls", "dirname", "cat", "df", "awk")


def run_setup(
    tmp_path: Path, python: str, *, free_mb: int | None = None
) -> "subprocess.CompletedProcess[str]":
    """Run the script with a PATH that holds a few tools only: no g++, no apt-get, no sudo."""
    tools = tmp_path / "bin"
    tools.mkdir()
    for name in TOOLS:
        found = shutil.which(name)
        assert found is not None, name
        (tools / name).symlink_to(found)
    if free_mb is not None:
        (tools / "df").unlink()
        (tools / "df").write_text(f"#!/bin/sh\necho header\necho disk 9999 9 {free_mb} 99% /\n")
        (tools / "df").chmod(0o755)
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


def test_a_disk_without_room_is_told_before_anything_is_installed(tmp_path: Path) -> None:
    answer = run_setup(tmp_path, sys.executable, free_mb=1200)
    assert answer.returncode == 2
    assert "1200 MB are free" in answer.stderr
    assert "needs about 4500 MB" in answer.stderr
    assert not (tmp_path / "venv").exists()
