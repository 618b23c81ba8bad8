"""The set-up on a machine that lacks something, and may not install it."""

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from support.documents import ROOT

TOOLS = ("bash", "sed", "id", "grep", "uname", "ls", "dirname", "cat", "df", "awk", "mkdir")
FULL_DISK = "echo header; echo disk 9999 9 1200 99% /"


def fake(path: Path, script: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/bash\n{script}\n")
    path.chmod(0o755)


def run_setup(
    tmp_path: Path,
    python: str,
    *,
    fakes: Mapping[str, str] | None = None,
    cwd: Path = ROOT,
    **variables: str,
) -> "subprocess.CompletedProcess[str]":
    """Run the script with a PATH that holds a few tools only: no g++, no apt-get, no sudo.

    `fakes` are scripts, by name, that stand there for tools, or beside them.
    """
    tools = tmp_path / "bin"
    for name, script in (fakes or {}).items():
        fake(tools / name, script)
    tools.mkdir(exist_ok=True)
    for name in TOOLS:
        found = shutil.which(name)
        assert found is not None, name
        if not (tools / name).exists():
            (tools / name).symlink_to(found)
    environment = {**os.environ, "PATH": str(tools), "PYTHON": python, **variables}
    return subprocess.run(
        ["bash", str(ROOT / "deploy" / "setup.sh")],
        cwd=cwd,
        env={**environment, "VENV": str(tmp_path / "venv")},
        capture_output=True,
        text=True,
        check=False,
    )


def test_llama_cpp_is_built_here_without_amx_and_not_taken_from_a_cache(tmp_path: Path) -> None:
    calls = tmp_path / "calls"
    fake(tmp_path / "venv/bin/python", f'echo "$CFLAGS|$CXXFLAGS|$CMAKE_ARGS|$*" >> "{calls}"')
    fake(tmp_path / "venv/bin/w2c", ":")
    shutil.copyfile(ROOT / "constraints.txt", tmp_path / "constraints.txt")
    present = dict.fromkeys(("python3", "g++", "nvidia-smi"), ":")
    libraries = {"ldconfig": "echo libgomp.so.1 libOSMesa.so.8"}
    answer = run_setup(
        tmp_path,
        "python3",
        fakes={**present, **libraries},
        cwd=tmp_path,
        EXTRAS="all,dev",
        CFLAGS="-O2",
        CXXFLAGS="",
        CMAKE_ARGS="",
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
    answer = run_setup(tmp_path, sys.executable, fakes={"df": FULL_DISK})
    assert answer.returncode == 2
    assert "1200 MB are free" in answer.stderr
    assert "needs about 4500 MB" in answer.stderr
    assert not (tmp_path / "venv").exists()
