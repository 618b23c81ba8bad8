"""Which model is loaded, and what is said when it cannot be."""

import json
import shutil
import time
from collections.abc import Sequence
from pathlib import Path

import pytest

from w2c.errors import ConfigError, ModelError
from w2c_grounding.card import CARD_FILE, ModelCard, read_card
from w2c_grounding.config import Config
from w2c_grounding.family import Evidence, RgbImage
from w2c_grounding.loaded import load_model
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.model_list import describe_models
from w2c_grounding.registry import EMBEDDED_NAME, family_of, load, resolve


def test_the_card_of_a_checkpoint_says_how_to_read_it(tiny_checkpoint: Path) -> None:
    _, card = load(ModelConfig(model=str(tiny_checkpoint)))
    assert card.name == "tiny"
    assert card.threshold == 0.01
    assert card.vocabulary == ["book", "cup", "red", "blue"]


def test_the_configuration_overrides_the_card(tiny_checkpoint: Path) -> None:
    config = ModelConfig(model=str(tiny_checkpoint), threshold=0.7, template="a {}")
    _, card = load(config)
    assert (card.threshold, card.template) == (0.7, "a {}")


def test_a_checkpoint_without_a_card_gets_its_name_from_the_directory(tmp_path: Path) -> None:
    card = read_card(tmp_path, tmp_path.name)
    assert card.name == tmp_path.name
    assert card.vocabulary is None


@pytest.mark.parametrize("model", ["/nowhere/at/all", "./missing", "~/missing", "a/b/c"])
def test_a_path_that_is_not_there_is_named(model: str) -> None:
    with pytest.raises(ModelError, match="no checkpoint directory"):
        resolve(ModelConfig(model=model))


def test_a_hub_id_is_passed_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    config = ModelConfig(model="CIDAS/clipseg-rd64-refined")
    assert resolve(config) == ("CIDAS/clipseg-rd64-refined", None)


def test_an_incomplete_directory_is_told_what_it_lacks(tmp_path: Path) -> None:
    (tmp_path / "config.json").write_text("{}")
    with pytest.raises(ModelError, match=r"lacks model\.safetensors or .*tokenizer\.json"):
        resolve(ModelConfig(model=str(tmp_path)))


def test_a_hub_id_that_is_not_here_is_an_error_not_a_download(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ModelError, match="--allow-download"):
        load(ModelConfig(model="nobody/has-this-model"))


@pytest.mark.parametrize("text", ["{", '{"name": "x", "threshold": 2.0}', '{"nam": "x"}'])
def test_a_malformed_card_is_an_error_with_its_path(tmp_path: Path, text: str) -> None:
    (tmp_path / CARD_FILE).write_text(text)
    with pytest.raises(ModelError, match=CARD_FILE):
        read_card(tmp_path, "x")


def test_an_unknown_family_is_told_the_known_ones() -> None:
    with pytest.raises(ConfigError, match=r"known: .*clipseg"):
        load(ModelConfig(family="oracle"))


def test_a_device_that_is_not_here_is_a_configuration_error(tiny_checkpoint: Path) -> None:
    with pytest.raises(ConfigError, match="try --device cpu"):
        load(ModelConfig(model=str(tiny_checkpoint), device="cuda:63"))


def test_damaged_weights_are_a_model_error(tiny_checkpoint: Path, tmp_path: Path) -> None:
    for file in tiny_checkpoint.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    (tmp_path / "model.safetensors").write_bytes(b"not weights")
    with pytest.raises(ModelError, match="cannot be loaded"):
        load(ModelConfig(model=str(tmp_path)))


def test_a_checkpoint_says_itself_which_family_reads_it(
    dino_checkpoint: Path, owlv2_checkpoint: Path, clip_checkpoint: Path, tiny_checkpoint: Path
) -> None:
    found = {
        family_of(ModelConfig(), str(directory), directory)
        for directory in (dino_checkpoint, owlv2_checkpoint, clip_checkpoint, tiny_checkpoint)
    }
    assert found == {"grounding-dino", "owlv2", "clip-surgery", "clipseg"}


def test_a_checkpoint_of_another_family_is_told_which_one_reads_it(clip_checkpoint: Path) -> None:
    config = ModelConfig(model=str(clip_checkpoint), family="clipseg")
    with pytest.raises(ModelError, match=r"'clip'.*reads clipseg: use --family clip-surgery"):
        load(config)


def test_a_checkpoint_that_no_family_reads_is_told_the_known_ones(tmp_path: Path) -> None:
    (tmp_path / "config.json").write_text('{"model_type": "resnet"}')
    for family in ("", "owlv2"):
        with pytest.raises(ModelError, match=r"'resnet'.*no family here reads"):
            family_of(ModelConfig(family=family), "there", tmp_path)


def test_a_malformed_configuration_is_a_model_error(tmp_path: Path) -> None:
    (tmp_path / "config.json").write_text("{")
    with pytest.raises(ModelError, match=r"config\.json cannot be read"):
        family_of(ModelConfig(), "there", tmp_path)


def test_weights_that_are_not_in_the_file_are_an_error_not_random_numbers(
    owlv2_checkpoint: Path, tmp_path: Path
) -> None:
    from safetensors.torch import load_file, save_file

    directory = tmp_path / "lacking"
    shutil.copytree(owlv2_checkpoint, directory)
    weights = load_file(directory / "model.safetensors")
    del weights["box_head.dense0.weight"]
    save_file(weights, directory / "model.safetensors", metadata={"format": "pt"})
    with pytest.raises(ModelError, match=r"lacks 1 weights .*box_head\.dense0\.weight"):
        load(ModelConfig(model=str(directory), threads=1))


def test_an_architecture_of_another_size_is_a_model_error(
    clip_checkpoint: Path, tmp_path: Path
) -> None:
    directory = tmp_path / "resized"
    shutil.copytree(clip_checkpoint, directory)
    values = json.loads((directory / "config.json").read_text())
    values["vision_config"]["hidden_size"] = 48
    (directory / "config.json").write_text(json.dumps(values))
    with pytest.raises(ModelError, match=r"check --family|not wholly"):
        load(ModelConfig(model=str(directory), threads=1))


def test_families_have_thresholds_of_their_own(owlv2_checkpoint: Path) -> None:
    _, card = load(ModelConfig(model=str(owlv2_checkpoint), threads=1))
    assert card.threshold == 0.1


@pytest.mark.parametrize("family", ["florence", "florence-outline", "sam3", "pointer"])
def test_a_family_without_a_size_to_choose_refuses_one_instead_of_ignoring_it(
    family: str, tmp_path: Path
) -> None:
    for name in ("model.safetensors", "preprocessor_config.json", "tokenizer.json"):
        (tmp_path / name).write_text("")
    kind = "sam3" if family == "sam3" else "florence2"
    (tmp_path / "config.json").write_text(json.dumps({"model_type": kind}))
    config = ModelConfig(model=str(tmp_path), family=family, input_size=480)
    with pytest.raises(ConfigError, match=rf"--input-size 480: family {family} has no size"):
        load(config)


def test_the_name_of_the_embedded_model_is_a_name_as_the_list_says() -> None:
    assert describe_models([], lambda _: False).startswith(f"{EMBEDDED_NAME} ")
    assert resolve(ModelConfig(model=EMBEDDED_NAME)) == resolve(ModelConfig())
    named = Config(robot="test", model=EMBEDDED_NAME).model_files()
    assert named is not None
    assert named == Config(robot="test").model_files()


class Unready:
    """A family whose layers do not fit the size that was chosen."""

    def prepare(self, image: RgbImage) -> None:
        raise RuntimeError("selected index k out of range")

    def query(self, context: None, phrases: Sequence[str]) -> list[Evidence]:
        return []


def test_a_model_that_cannot_answer_is_a_model_error_at_the_start() -> None:
    def load_unready(_: ModelConfig) -> tuple[Unready, ModelCard]:
        return Unready(), ModelCard(name="mine")

    with pytest.raises(ModelError, match=r"mine was loaded and cannot answer: .*index k.*--input"):
        load_model(load_unready, ModelConfig(input_size=16), "interior", time.monotonic_ns)
