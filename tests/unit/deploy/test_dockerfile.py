"""The image is made of files that are sent to the builder, and of what the set-up installs too."""

import re

from support.deploy import ROOT

DOCKERFILE = (ROOT / "deploy" / "Dockerfile").read_text()


def apt_packages() -> list[set[str]]:
    """Return the packages of each apt-get install."""
    joined = DOCKERFILE.replace("\\\n", " ")
    return [
        {word for word in match.split() if not word.startswith("-")}
        for match in re.findall(r"apt-get install (.*?)&&", joined)
    ]


def test_what_is_copied_is_in_the_context() -> None:
    copied = [
        source
        for line in re.findall(r"^COPY (?!--from)(.*)$", DOCKERFILE, re.MULTILINE)
        for source in line.split()[:-1]
    ]
    sent = {
        line.removeprefix("!")
        for line in (ROOT / ".dockerignore").read_text().splitlines()
        if line.startswith("!")
    }

    assert set(copied) == sent
    assert all((ROOT / source).exists() for source in sent)


def test_the_running_image_has_opengl_and_openmp_and_no_compiler() -> None:
    build, run = apt_packages()

    assert {"libegl1", "libegl-mesa0", "libgl1-mesa-dri", "libosmesa6", "libgomp1"} <= run
    assert "g++" in build
    assert "g++" not in run


def test_the_lock_is_used_for_every_package() -> None:
    assert "--constraint constraints.txt" in DOCKERFILE
    assert "llama-cpp-python==$(sed -n 's/^llama-cpp-python==//p' constraints.txt)" in DOCKERFILE
    locked = (ROOT / "constraints.txt").read_text()
    assert re.search(r"^llama-cpp-python==\d", locked, re.MULTILINE)
    assert re.search(r"^torch==[\d.]+$", locked, re.MULTILINE)


def test_the_image_runs_without_root() -> None:
    last_stage = DOCKERFILE.split("\nFROM ")[-1]
    users = re.findall(r"^USER (.*)$", last_stage, re.MULTILINE)

    assert users == ["1000:1000"]
