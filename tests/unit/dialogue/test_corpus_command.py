"""`w2c dialogue corpus`: the same files for the same seed, and no nonsense."""

import json
from pathlib import Path

import pytest

from w2c_dialogue.__main__ import main


def test_the_command_writes_the_same_files_for_the_same_seed(tmp_path: Path) -> None:
    for name in ("one", "two"):
        assert (
            main(
                [
                    "corpus",
                    "--out",
                    str(tmp_path / name),
                    "--count",
                    "60",
                    "--held-out",
                    "20",
                    "--seed",
                    "5",
                ]
            )
            == 0
        )
    for file, count in (("train.jsonl", 60), ("heldout.jsonl", 20)):
        lines = (tmp_path / "one" / file).read_bytes()
        assert lines == (tmp_path / "two" / file).read_bytes()
        rows = [json.loads(line) for line in lines.splitlines()]
        assert len(rows) == count
        assert set(rows[0]) == {"task", "messages", "answer"}


def test_the_command_refuses_nonsense(tmp_path: Path) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["corpus", "--out", str(tmp_path), "--count", "0"])
    assert caught.value.code == 2
    blocked = tmp_path / "file"
    blocked.write_text("")
    assert main(["corpus", "--out", str(blocked / "x"), "--count", "5"]) == 1
