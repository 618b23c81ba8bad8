"""Public models by name."""

from pathlib import Path

import pytest

from w2c.errors import ModelError
from w2c_grounding.commands import ground
from w2c_grounding.known import KNOWN, read_known
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.model_list import describe_models, is_in_cache
from w2c_grounding.registry import FAMILIES, load


@pytest.mark.parametrize("name", sorted(KNOWN))
def test_every_known_model_names_a_family_a_hub_id_and_whose_licence(name: str) -> None:
    model = KNOWN[name]
    assert model.family in FAMILIES
    assert model.model.count("/") == 1
    assert model.licence
    assert model.licence_source


def test_a_name_fills_in_what_the_configuration_leaves_open() -> None:
    config = KNOWN["owlv2-base"].applied_to(ModelConfig(model="owlv2-base", threshold=0.7))
    assert config.family == "owlv2"
    assert config.model == "google/owlv2-base-patch16-ensemble"
    assert (config.template, config.threshold) == ("a photo of a {}", 0.7)


def test_a_known_model_that_is_not_here_is_an_error_with_its_hub_id(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ModelError, match=r"grounding-dino-tiny'.*--allow-download"):
        load(ModelConfig(model="grounding-dino-tiny"))


def test_the_list_says_what_is_here_what_a_fetch_takes_and_the_licence() -> None:
    chosen = [KNOWN["clipseg"], KNOWN["owlv2-large"]]
    text = describe_models(chosen, lambda model: model.name == "clipseg")
    lines = text.splitlines()
    assert lines[2].endswith("here")
    assert "released for research purposes" in lines[3]
    assert lines[4].endswith("not here; to fetch: size not known")
    assert "google/owlv2-large-patch14-ensemble, licence: Apache-2.0 (model page)" in lines[5]


def test_the_verb_prints_it_without_a_system(capsys: pytest.CaptureFixture[str]) -> None:
    assert ground(["models"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in KNOWN)


def test_a_model_is_here_once_configuration_and_weights_are_in_the_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import huggingface_hub.constants as hub

    monkeypatch.setattr(hub, "HF_HUB_CACHE", str(tmp_path))
    model = KNOWN["clipseg"]
    repository = tmp_path / "models--CIDAS--clipseg-rd64-refined"
    snapshot = repository / "snapshots" / "abc"
    snapshot.mkdir(parents=True)
    (repository / "refs").mkdir()
    (repository / "refs" / "main").write_text("abc")
    (snapshot / "config.json").write_text("{}")
    assert not is_in_cache(model)
    (snapshot / "pytorch_model.bin").write_bytes(b"")
    assert is_in_cache(model)


ROW = """
[[model]]
name = "one"
family = "clipseg"
model = "a/b"
gives = "heatmap"
licence = "MIT"
licence_source = "model page"
"""


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (ROW + ROW, "twice"),
        (ROW + 'colour = "red"', "colour"),
        (ROW + 'template = "no place"', "exactly one"),
        (ROW + "threshold = 2.0", "threshold"),
    ],
)
def test_a_table_with_a_mistake_is_refused(tmp_path: Path, text: str, complaint: str) -> None:
    path = tmp_path / "models.toml"
    path.write_text(text)
    with pytest.raises(Exception, match=complaint):
        read_known(path)
