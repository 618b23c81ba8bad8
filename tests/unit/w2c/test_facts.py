"""What a health report tells of a process: configuration, and which model it runs."""

import hashlib
import json
from pathlib import Path

import msgspec
import pytest

from support.waiting import wait_until
from w2c.facts import Facts, checksum_of


class Config(msgspec.Struct, frozen=True):
    """Of a process with a model."""

    robot: str
    model: str

    def model_files(self) -> Path | None:
        return Path(self.model) if self.model else None


@pytest.fixture
def model(tmp_path: Path) -> Path:
    directory = tmp_path / "model"
    (directory / "part").mkdir(parents=True)
    (directory / "a.bin").write_bytes(b"weights")
    (directory / "part" / "b.bin").write_bytes(b"more")
    return directory


def test_a_file_has_its_sha256(model: Path) -> None:
    expected = hashlib.sha256(b"weights").hexdigest()
    assert checksum_of(model / "a.bin") == expected


def test_a_directory_is_told_from_another_by_names_and_contents(model: Path) -> None:
    found = {checksum_of(model)}
    (model / "a.bin").write_bytes(b"Weights")
    found.add(checksum_of(model))
    (model / "a.bin").rename(model / "c.bin")
    found.add(checksum_of(model))

    assert len(found) == 3


def test_configuration_and_checksum_are_told(model: Path) -> None:
    facts = Facts(Config(robot="talos", model=str(model)))

    assert json.loads(facts()["configuration"]) == {"robot": "talos", "model": str(model)}
    wait_until(lambda: "model_sha256" in facts())
    assert facts()["model_sha256"] == checksum_of(model)
    assert facts()["model"] == str(model)


def test_a_model_that_is_not_there_is_said_to_be_unknown(tmp_path: Path) -> None:
    facts = Facts(Config(robot="talos", model=str(tmp_path / "none.gguf")))

    wait_until(lambda: "model_sha256" in facts())
    assert facts()["model_sha256"] == "not known: No such file or directory"


def test_a_configuration_with_paths_is_told() -> None:
    class WithPath(msgspec.Struct):
        place: Path

    assert json.loads(Facts(WithPath(Path("runs/x")))()["configuration"]) == {"place": "runs/x"}


def test_a_process_without_a_model_tells_its_configuration() -> None:
    assert list(Facts(Config(robot="talos", model=""))()) == ["configuration"]
