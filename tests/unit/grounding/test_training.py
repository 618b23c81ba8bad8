"""The parts of the training, and a very short one of the whole."""

import json
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from fakes.rendered import write_pictures
from w2c.errors import ConfigError
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import load
from w2c_grounding.train.augment import normalise, vary
from w2c_grounding.train.commands import train
from w2c_grounding.train.data import load_pictures
from w2c_grounding.train.loss import mask_loss, patch_loss, patch_targets
from w2c_grounding.train.model import Size, new_model, new_processor, start_patches
from w2c_grounding.train.phrases import tokenizer_words, vocabulary_of
from w2c_grounding.train.score import Trial, calibrate, summarise
from w2c_grounding.train.tokens import learn_merges, make_tokenizer
from w2c_grounding.train.trainer import Plan, Trainer

TINY = Size(
    image=64,
    patch=16,
    width=32,
    layers=2,
    heads=2,
    extract=(0, 1),
    text_width=32,
    text_layers=1,
    projection=16,
    reduced=16,
)
lower_case = st.lists(st.text("abcdefgh", min_size=1, max_size=7), min_size=1, max_size=12)


@settings(deadline=None, max_examples=40)
@given(lower_case)
def test_every_word_of_the_training_becomes_one_token(spelled: list[str]) -> None:
    tokenizer = make_tokenizer(spelled, 24)
    for word in spelled:
        assert tokenizer.tokenize(word) == [word + "</w>"]


def test_merges_depend_on_the_set_of_words_only() -> None:
    assert learn_merges(["cup", "book", "cups"]) == learn_merges(["cups", "book", "cup", "book"])


def test_any_text_has_tokens_and_they_end_with_the_last_id() -> None:
    tokenizer = make_tokenizer(["book"], 24)
    ids = tokenizer("Zoë's 9 books?").input_ids
    assert ids[-1] == len(tokenizer) - 1
    assert tokenizer.unk_token_id not in ids[1:-1]


def test_the_loss_is_least_for_the_mask_itself_and_counts_false_peaks() -> None:
    masks = torch.zeros(2, 32, 32)
    masks[0, 4:12, 4:12] = 1.0
    weights = torch.ones(2)
    right = 20.0 * (masks - 0.5)
    assert float(mask_loss(right, masks, weights)) < 0.01
    assert float(mask_loss(-right, masks, weights)) > 1.0
    one_hot_pixel = right.clone()
    one_hot_pixel[1, 20, 20] = 5.0
    extra = mask_loss(one_hot_pixel, masks, weights) - mask_loss(right, masks, weights)
    # The mean over 1024 pixels alone would see 4 x 15 / 1024 / 2 = 0.03 at most.
    assert float(extra) > 0.2


def test_a_weight_of_zero_leaves_a_phrase_out() -> None:
    masks = torch.zeros(2, 16, 16)
    wrong = torch.full((2, 16, 16), -20.0)
    wrong[1] = 20.0
    assert float(mask_loss(wrong, masks, torch.tensor([1.0, 0.0]))) < 0.01


def test_patches_are_told_which_share_of_them_shows_what() -> None:
    owners = torch.zeros(1, 32, 32, dtype=torch.uint8)
    owners[0, :16, :8] = 3
    classes = torch.zeros(1, 256, 2)
    classes[0, 3, 1] = 1.0
    shares = patch_targets(owners, classes, 16)
    assert shares.shape == (1, 4, 2)
    assert shares[0].tolist() == [[0.0, 0.5], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]]


def test_changes_keep_picture_and_identity_together() -> None:
    """The object is the only red thing; wherever it goes, its identity goes too."""
    pixels = torch.full((32, 3, 64, 64), 0.3)
    owners = torch.zeros(32, 64, 64, dtype=torch.uint8)
    owners[:, 10:40, 30:60] = 7
    pixels[:, 0][owners == 7] = 0.9
    changed, moved = vary(pixels, owners, torch.Generator().manual_seed(0))
    assert changed.shape == pixels.shape
    assert 0.0 <= float(changed.min()) <= float(changed.max()) <= 1.0
    redness = changed[:, 0] - changed[:, 1:].mean(dim=1)
    agree = ((redness > 0.25) == (moved == 7)).float().mean(dim=(1, 2))
    assert float(agree.min()) > 0.9
    assert not bool((moved == owners).all()), "nothing was moved"


def test_patches_start_as_principal_components() -> None:
    model = new_model(TINY, 600)
    pictures = normalise(torch.rand(16, 3, 64, 64, generator=torch.Generator().manual_seed(1)))
    start_patches(model, pictures)
    embedded = model.clip.vision_model.embeddings.patch_embedding(pictures).detach()
    features = embedded.flatten(2).transpose(1, 2).reshape(-1, TINY.width)
    covariance = torch.cov(features.T)
    spread = covariance.diagonal()
    assert float(spread.max() / spread.min()) < 3.0
    correlation = covariance / torch.outer(spread, spread).sqrt() - torch.eye(TINY.width)
    assert float(correlation.abs().max()) < 1e-2


def tiny_trainer(directory: Path, minutes: float) -> Trainer:
    torch.manual_seed(0)
    pictures = load_pictures(write_pictures(directory, 8), TINY.image)
    processor = new_processor(TINY, tokenizer_words(vocabulary_of(pictures.truths)))
    model = new_model(TINY, len(processor.tokenizer))
    plan = Plan(minutes=minutes, batch=4, favourites=("disc",))
    return Trainer(model, processor, pictures, TINY, plan)


def test_training_changes_the_average_and_continues_where_it_stopped(tmp_path: Path) -> None:
    trainer = tiny_trainer(tmp_path / "data", 0.02)
    before = {name: value.clone() for name, value in trainer.model.state_dict().items()}
    trainer.run(tmp_path / "state.pt", lambda _: None)
    assert trainer.steps > 0
    after = trainer.averaged().state_dict()
    assert any(not torch.equal(after[name], before[name]) for name in before)

    again = tiny_trainer(tmp_path / "data", 0.02)
    again.resume(tmp_path / "state.pt")
    assert (again.steps, again.seconds) == (trainer.steps, trainer.seconds)
    continued = again.averaged().state_dict()
    assert all(torch.equal(continued[name], after[name]) for name in after)
    # The time of the plan is used up: nothing is left to do.
    again.run(tmp_path / "state.pt", lambda _: None)
    assert again.steps == trainer.steps


def test_a_state_that_is_none_is_refused(tmp_path: Path) -> None:
    trainer = tiny_trainer(tmp_path / "data", 0.01)
    with pytest.raises(ConfigError, match="without --resume"):
        trainer.resume(tmp_path / "none.pt")


def trial(score: float, kind: str = "", *, hits: bool = False) -> Trial:
    return Trial("x", kind, False, score, hits, hits)


def test_the_threshold_turns_down_the_wanted_share_of_absent_phrases() -> None:
    absent = [trial(score) for score in np.linspace(0.1, 0.6, 101)]
    threshold = calibrate([*absent, trial(0.9, "book", hits=True)], 0.9)
    scores = summarise([*absent, trial(0.9, "book", hits=True)], threshold)
    assert scores["absent_rejected"] == pytest.approx(0.9, abs=0.02)
    assert scores["found"] == 1.0
    assert scores["pointing.book"] == 1.0


def test_calibration_without_absent_phrases_is_refused() -> None:
    with pytest.raises(ConfigError, match="no absent phrase"):
        calibrate([trial(0.9, "book")])


def test_the_command_leaves_a_checkpoint_that_loads_and_its_scores(tmp_path: Path) -> None:
    write_pictures(tmp_path / "data", 24)
    flags = ["--data", str(tmp_path / "data"), "--out", str(tmp_path / "out"), "--threads", "1"]
    assert train([*flags, "--minutes", "0.01"]) == 0
    family, card = load(ModelConfig(model=str(tmp_path / "out" / "checkpoint"), threads=1))
    assert card.vocabulary is not None
    assert {"square", "red"} <= set(card.vocabulary)
    image = np.zeros((90, 160, 3), dtype=np.uint8)
    assert len(family.query(family.prepare(image), ["square", "disc"])) == 2
    scores = json.loads((tmp_path / "out" / "scores.json").read_text())
    assert scores["threshold"] == card.threshold
    assert scores["present_phrases"] == 8


def test_the_command_says_what_is_missing(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="w2c scenes render"):
        train(["--data", str(tmp_path / "none"), "--out", str(tmp_path / "out")])


def test_patches_that_say_what_they_show_lose_least() -> None:
    shares = torch.tensor([[[1.0, 0.0], [0.0, 0.5], [0.0, 0.0]]])
    right = torch.tensor([[[20.0, -20.0], [-20.0, 0.0], [-20.0, -20.0]]])
    wrong = right.flip(dims=(2,))
    assert float(patch_loss(right, shares)) < 0.5
    assert float(patch_loss(wrong, shares)) > 5.0
