"""`w2c ground` on a picture file."""

from pathlib import Path

import numpy as np
import pytest

from w2c.errors import ConfigError, ConnectionFailedError, ModelError, RefusedError
from w2c.messages import Box, PhraseEvidence
from w2c_grounding import registry
from w2c_grounding.card import ModelCard
from w2c_grounding.commands import describe, ground
from w2c_grounding.family import RgbImage
from w2c_grounding.picture import decode, encode_png


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    path = tmp_path / "scene.png"
    noise = np.random.default_rng(0).integers(0, 255, (72, 128, 3), dtype=np.uint8)
    path.write_bytes(encode_png(noise))
    return path


def test_it_draws_the_answer_and_prints_a_line_a_phrase(
    picture: Path, tiny_checkpoint: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "drawn" / "answer.png"
    flags = ["--image", str(picture), "--model", str(tiny_checkpoint), "--out", str(out)]
    assert ground(["book", "flurb", *flags, "--threads", "1"]) == 0
    drawn = decode(out.read_bytes())
    assert drawn.shape == (72, 128, 3)
    assert (drawn != decode(picture.read_bytes())).any()
    printed = capsys.readouterr().out
    assert "book: " in printed
    assert "never seen: flurb" in printed


def test_what_is_wrong_is_said(picture: Path, tiny_checkpoint: Path, tmp_path: Path) -> None:
    model = ["--model", str(tiny_checkpoint)]
    with pytest.raises(ConfigError, match="cannot be read"):
        ground(["book", "--image", str(tmp_path / "none.jpg"), *model])
    with pytest.raises(ModelError, match="no checkpoint directory"):
        ground(["book", "--image", str(picture), "--model", str(tmp_path / "none")])
    with pytest.raises(RefusedError, match="no word"):
        ground(["!", "--image", str(picture), *model])
    broken = tmp_path / "broken.jpg"
    broken.write_bytes(b"no picture")
    with pytest.raises(RefusedError, match="neither JPEG nor PNG"):
        ground(["book", "--image", str(broken), *model])


def test_a_model_whose_layers_do_not_take_the_size_is_told_without_a_trace(
    picture: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Unready:
        def prepare(self, image: RgbImage) -> None:
            raise RuntimeError("selected index k out of range")

    monkeypatch.setattr(registry, "load", lambda _: (Unready(), ModelCard(name="mine")))
    with pytest.raises(ModelError, match=r"mine was loaded and cannot answer: .*--input-size out"):
        ground(["book", "--image", str(picture), "--input-size", "16"])


def test_no_phrase_is_a_usage_error(picture: Path) -> None:
    with pytest.raises((ConfigError, SystemExit)):
        ground(["--image", str(picture)])


def test_an_unknown_flag_ends_with_status_2() -> None:
    with pytest.raises(SystemExit) as ended:
        ground(["book", "--colour", "red"])
    assert ended.value.code == 2


def test_without_a_picture_and_without_a_system_it_says_how_to_start_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConnectionFailedError, match="w2c up"):
        ground(["book"])


def test_a_line_names_point_box_score_and_how_many_more() -> None:
    boxes = [Box(left=1, top=2, right=30, bottom=40, score=0.9)] * 2
    found = PhraseEvidence(phrase="cup", found=True, score=0.9, point=(15.5, 20.5), boxes=boxes)
    assert describe(found) == "  cup: point (16, 20), box [1 2 30 40] and 1 more, score 0.90"
    absent = PhraseEvidence(phrase="cup", found=False, score=0.1, point=None, boxes=[])
    assert describe(absent) == "  cup: not found, score 0.10"


def test_too_many_phrases_or_too_long_a_one_are_refused_with_the_limit(picture: Path) -> None:
    with pytest.raises((ConfigError, SystemExit)):
        ground([*["cup"] * 200, "--image", str(picture)])
    with pytest.raises(ConfigError, match="100"):
        ground(["cup " * 250, "--image", str(picture)])


@pytest.mark.parametrize("family", ["dino_checkpoint", "owlv2_checkpoint", "clip_checkpoint"])
def test_every_family_answers_through_the_verb(
    family: str, picture: Path, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    out = tmp_path / "answer.png"
    model = ["--model", str(request.getfixturevalue(family)), "--threads", "1"]
    flags = ["--image", str(picture), "--out", str(out), "--threshold", "0.001", *model]
    phrases = ["red cup", "3.5 inch disk.", "красная чашка"]
    assert ground([*phrases, *flags]) == 0
    assert (decode(out.read_bytes()) != decode(picture.read_bytes())).any()
