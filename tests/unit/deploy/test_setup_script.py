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


def fake(path: Path, script: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/bash\n{script}\n")
    path.chmod(0o755)


def test_llama_cpp_is_built_here_without_amx_and_not_taken_from_a_cache(tmp_path: Path) -> None:
    calls = tmp_path / "calls"
    note = f'echo "$CFLAGS|$CXXFLAGS|$CMAKE_ARGS|$*" >> {calls}'
    tools = tmp_path / "bin"
    for name, script in (
        ("python3", ":"),
        ("g++", ":"),
        ("nvidia-smi", ":"),
        ("ldconfig", "echo libgomp.so.1 libOSMesa.so.8"),
    ):
        fake(tools / name, script)
    for name in (*TOOLS, "mkdir"):
        if name != "bash":
            (tools / name).symlink_to(str(shutil.which(name)))
    fake(tmp_path / "venv/bin/python", note)
    fake(tmp_path / "venv/bin/w2c", ":")
    shutil.copyfile(ROOT / "constraints.txt", tmp_path / "constraints.txt")
    answer = subprocess.run(
        [str(shutil.which("bash")), str(ROOT / "deploy" / "setup.sh")],
        cwd=tmp_path,
        env={"PATH": str(tools), "PYTHON": "python3", "VENV": "venv", "CFLAGS": "-O2"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode == 0, answer.stderr
    (build,) = [line for line in calls.read_text().splitlines() if " wheel " in line]
    flags, flags_of_cpp, cmake, arguments = build.split("|")
    assert flags == "-U__AMX_INT8__ -O2"
    assert flags_of_cpp.strip() == "-U__AMX_INT8__"
    assert "-DLLAVA_BUILD=OFF" in cmake
    assert "--no-cache-dir" in arguments
    assert arguments.split()[-1].startswith("llama-cpp-python==")


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
