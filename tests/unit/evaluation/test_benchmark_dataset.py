"""Folders of pictures, prompts and masks, of any maker: what is read, and what is wrong."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from w2c.errors import ConfigError
from w2c_evaluation.benchmark import dataset
from w2c_evaluation.benchmark.commands import main
from w2c_evaluation.benchmark.dataset import load, read, read_mask

SIZE = (24, 32)
LINE = '{"id": "%s", "prompt": "touch the cup", "position": "absolute"}\n'


def mask(columns: int = 10) -> np.ndarray:
    found = np.zeros(SIZE, np.uint8)
    found[:, :columns] = 255
    return found


def write(path: Path, pixels: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), pixels)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a sound folder of two."""
    for name in ("a", "b"):
        write(tmp_path / "images" / f"{name}.jpg", np.full((*SIZE, 3), 90, np.uint8))
        write(tmp_path / "masks" / f"{name}.png", mask())
    (tmp_path / "prompts.jsonl").write_text(LINE % "a" + LINE % "b")
    return tmp_path


def test_files_are_found_by_id(folder: Path) -> None:
    items = load(folder)

    assert [item.record.id for item in items] == ["a", "b"]
    assert items[0].accepted().sum() == 10 * SIZE[0]
    assert items[0].picture().startswith(b"\xff\xd8")
    assert read(folder)[1] == []


def test_a_table_is_read_as_lines_are(folder: Path) -> None:
    (folder / "prompts.jsonl").unlink()
    (folder / "prompts.csv").write_text(
        'id,prompt,position\na,"touch the cup, please",absolute\nb,left of it,relative\n'
    )

    assert [(i.record.prompt, i.record.position) for i in load(folder)] == [
        ("touch the cup, please", "absolute"),
        ("left of it", "relative"),
    ]


def test_paths_may_be_given(folder: Path) -> None:
    (folder / "images" / "a.jpg").rename(folder / "first.jpg")
    line = '{"id": "a", "prompt": "x", "position": "relative", "image": "first.jpg"}\n'
    (folder / "prompts.jsonl").write_text(line + LINE % "b")

    assert load(folder)[0].image == folder / "first.jpg"


@pytest.mark.parametrize(
    ("pixels", "accepted"),
    [
        (mask(), 10),
        ((mask() > 0).astype(np.uint8), 10),
        (mask().astype(np.uint16) * 257, 10),
        (np.dstack([mask(), mask(5) * 0, mask() * 0]), 10),
        (np.dstack([mask(), mask() * 0, mask() * 0, np.full(SIZE, 255, np.uint8)]), 10),
    ],
    ids=["black and white", "zeros and ones", "16 bit", "coloured", "opaque"],
)
def test_masks_of_many_editors_are_read(tmp_path: Path, pixels: np.ndarray, accepted: int) -> None:
    write(tmp_path / "mask.png", pixels)

    assert read_mask(tmp_path / "mask.png").sum() == accepted * SIZE[0]


def _without(name: str) -> Callable[[Path], None]:
    return lambda folder: (folder / name).unlink()


def _with_mask(pixels: np.ndarray) -> Callable[[Path], None]:
    return lambda folder: write(folder / "masks" / "b.png", pixels)


def _with_line(text: str) -> Callable[[Path], None]:
    def spoil(folder: Path) -> None:
        (folder / "prompts.jsonl").write_text(LINE % "a" + text)

    return spoil


def _cut_short(folder: Path) -> None:
    path = folder / "images" / "b.jpg"
    path.write_bytes(path.read_bytes()[:20])


def _with_things(things: str) -> Callable[[Path], None]:
    start = '{"id": "b", "prompt": "Touch the red  CUP", "position": "absolute", "things": '
    return _with_line(f"{start}{things}}}\n")


def _with_a_bitmap(folder: Path) -> None:
    write(folder / "b.bmp", np.full((*SIZE, 3), 90, np.uint8))
    (folder / "b.bmp").rename(folder / "images" / "b.jpg")


@pytest.mark.parametrize(
    ("spoil", "fault"),
    [
        (_without("masks/b.png"), "(b): there is no masks/b with any of"),
        (_without("images/b.jpg"), "(b): there is no images/b with any of"),
        (_with_mask(mask()[:12]), "has 32x24 px, its mask 32x12"),
        (_with_mask(mask(0)), "the mask is empty"),
        (_with_mask(mask(32)), "the mask is full"),
        (_cut_short, "images/b.jpg is no picture"),
        (_with_line("{"), "prompts.jsonl, line 2: "),
        (_with_line(LINE % "a"), "the id is used twice"),
        (_with_line('{"id": "b", "prompt": "x", "position": "above"}\n'), "position"),
        (_with_line('{"id": "b", "prompt": " ", "position": "absolute"}\n'), "prompt"),
        (_with_line('{"id": "../b", "prompt": "x", "position": "absolute"}\n'), "id"),
        (
            _with_line('{"id":"b","prompt":"x","position":"absolute","mask":"../m.png"}\n'),
            "leads out of the folder",
        ),
        (_with_things("[]"), "things is empty"),
        (_with_things('[{"words": "mug", "box": [1, 1, 9, 9]}]'), "does not say 'mug'"),
        (_with_things('[{"words": "red cup", "box": [9, 1, 9, 9]}]'), "(9, 1, 9, 9), expected"),
        (_with_things('[{"words": "cup", "box": [0, 0, 33, 9]}]'), "within 32x24"),
        (_with_a_bitmap, "JPEG nor PNG inside: convert it"),
        (_with_line(""), "images/b.jpg: no prompt belongs to it"),
        (_without("prompts.jsonl"), "has neither prompts.jsonl nor prompts.csv"),
    ],
)
def test_a_fault_is_named_and_spoils_nothing_else(
    folder: Path,
    spoil: Callable[[Path], None],
    fault: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    spoil(folder)
    items, faults = read(folder)

    assert any(fault in found for found in faults), faults
    assert [item.record.id for item in items] == (["a"] if "neither" not in fault else [])
    with pytest.raises(ConfigError, match="w2c benchmark check"):
        load(folder)
    assert main(["check", str(folder)]) == 1
    assert fault in capsys.readouterr().out


def test_a_picture_that_is_too_large_for_a_request_is_told(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dataset, "MOST_PIXELS", SIZE[0] * SIZE[1] - 1)
    assert all("make it smaller" in fault for fault in read(folder)[1])
    assert read(folder)[0] == []


def test_things_in_the_picture_that_the_prompt_says_are_sound(folder: Path) -> None:
    _with_things('[{"words": "red cup", "box": [0, 0, 32, 24]}]')(folder)
    assert read(folder)[1] == []


def test_a_sound_folder_passes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(folder)]) == 0
    told = capsys.readouterr().out
    assert "2 sound, 0 faults" in told
    assert "random points hit: absolute 0.312, overall 0.312" in told
    assert "limit missed" not in told


def test_a_missing_folder_says_how_to_make_one(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="w2c benchmark make"):
        load(tmp_path / "none")
