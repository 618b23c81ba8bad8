"""The parts of the training: words, losses, model, start, optimiser, plan."""

import math
from copy import deepcopy
from dataclasses import replace
from typing import Any

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from fakes.tiny_models import TINY
from w2c_grounding.train.augment import normalise
from w2c_grounding.train.loss import mask_loss, patch_loss, patch_targets
from w2c_grounding.train.model import LOUDEST, decode, features, new_model, quieten
from w2c_grounding.train.optimizer import Optimizer, orthogonalised
from w2c_grounding.train.plan import Plan, Progress, learning_rate
from w2c_grounding.train.start import OFFSETS, frequencies, start_tower, turn, wave_count
from w2c_grounding.train.tokens import learn_merges, make_tokenizer

SMALL = replace(TINY, image=128, width=64)
lower_case = st.lists(st.text("abcdefgh", min_size=1, max_size=7), min_size=1, max_size=12)


@settings(max_examples=15)
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


def test_of_two_things_the_smaller_counts_as_much_as_the_larger() -> None:
    shares = torch.zeros(1, 64, 64)
    shares[0, :32, :32] = 1.0 / 32**2
    shares[0, 40:44, 40:44] = 1.0 / 4**2
    right = 20.0 * ((shares > 0).float() - 0.5)
    without_small, small = right.clone(), right[0, 40:44, 40:44]
    without_small[0, 40:44, 40:44] = -4.0
    extra = mask_loss(without_small, shares, torch.ones(1)) - mask_loss(
        right, shares, torch.ones(1)
    )
    assert small.numel() * 40 < int((shares > 0).sum())
    # Half of the things are missed by 4; the mean over 4096 pixels sees 0.06 of it.
    assert float(extra) == pytest.approx(0.25 * 0.5 * 4.0 + 0.07, abs=0.03)


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


def test_a_phrase_that_fits_nothing_has_a_finite_gradient() -> None:
    logits = torch.zeros(2, 16, 16, requires_grad=True)
    masks = torch.zeros(2, 16, 16)
    masks[0, :4, :4] = 1.0
    mask_loss(logits, masks, torch.ones(2)).backward()  # type: ignore[no-untyped-call]
    assert logits.grad is not None
    assert bool(torch.isfinite(logits.grad).all())
    assert bool((logits.grad[0][masks[0] == 1] < 0).all())


def test_patches_that_say_what_they_show_lose_least() -> None:
    shares = torch.tensor([[[1.0, 0.0], [0.0, 0.5], [0.0, 0.0]]])
    right = torch.tensor([[[20.0, -20.0], [-20.0, 0.0], [-20.0, -20.0]]])
    wrong = right.flip(dims=(2,))
    assert float(patch_loss(right, shares)) < 0.5
    assert float(patch_loss(wrong, shares)) > 5.0


@pytest.fixture(scope="module")
def pictures() -> torch.Tensor:
    """Patches of one colour and of noise, in turns: they differ much in size."""
    generator = torch.Generator().manual_seed(1)
    pixels = torch.rand(4, 3, 1, 1, generator=generator).expand(4, 3, 128, 128).clone()
    noise = torch.rand(4, 3, 128, 128, generator=generator)
    rough = (torch.arange(128) // 16 % 2 == 0).float()
    return normalise(torch.lerp(pixels, noise, rough[None, None, :, None]))


@pytest.fixture(scope="module")
def started(pictures: torch.Tensor) -> torch.nn.Module:
    torch.manual_seed(0)
    model: torch.nn.Module = new_model(SMALL, 600)
    start_tower(model, SMALL, pictures)
    return model.eval()


def attention_of(model: torch.nn.Module, number: int, hidden: torch.Tensor) -> torch.Tensor:
    """Return (n, heads, from, to)."""
    layer = model.get_submodule(f"clip.vision_model.encoder.layers.{number}")
    normalised = layer.get_submodule("layer_norm1")(hidden)
    shape = (*hidden.shape[:2], SMALL.heads, -1)
    queries, keys = (
        layer.get_submodule(f"self_attn.{name}")(normalised).view(shape).transpose(1, 2)
        for name in ("q_proj", "k_proj")
    )
    weights: torch.Tensor = (queries @ keys.mT / math.sqrt(queries.shape[-1])).softmax(dim=-1)
    return weights


@pytest.mark.parametrize("number", [0, 1])
def test_a_head_begins_by_looking_at_one_neighbour(
    started: torch.nn.Module, pictures: torch.Tensor, number: int
) -> None:
    with torch.no_grad():
        tower = started.get_submodule("clip.vision_model")
        embedded = tower.get_submodule("embeddings")(pictures)
        hidden = tower.get_submodule("pre_layrnorm")(embedded)
        if number == 1:
            (hidden, _) = features(started, pictures)
        weights = attention_of(started, number, hidden)[:, 0, 1:, 1:]
    row, column = OFFSETS[number][0]
    cells = torch.arange(SMALL.cells**2).view(SMALL.cells, SMALL.cells)
    inside = cells[1:-1, 1:-1].flatten()
    wanted = inside + row * SMALL.cells + column
    assert float(weights[:, inside, wanted].mean()) > 0.7
    assert bool((weights[:, inside].argmax(dim=-1) == wanted).all())


def test_a_turn_moves_a_position_by_the_offset() -> None:
    places = torch.tensor([[2.0, 5.0], [3.0, 3.0]])  # row and column; the second is (1, -2) away
    angles = places[:, :, None] * frequencies(SMALL)
    waves = torch.cat([angles.sin(), angles.cos()], dim=2).flatten(1)
    torch.testing.assert_close(turn((1, -2), SMALL) @ waves[0], waves[1])


def test_patches_start_alike_loud_and_apart_from_positions(
    started: torch.nn.Module, pictures: torch.Tensor
) -> None:
    embedding = started.get_submodule("clip.vision_model.embeddings.patch_embedding")
    shown = embedding(pictures).detach().flatten(2).transpose(1, 2).reshape(-1, SMALL.width)
    content = SMALL.width - 4 * wave_count(SMALL)
    assert float(shown[:, content:].abs().max()) == 0.0
    covariance = torch.cov(shown[:, :content].T)
    spread = covariance.diagonal()
    correlation = covariance / torch.outer(spread, spread).sqrt() - torch.eye(content)
    assert float(correlation.abs().max()) < 1e-2


def test_features_and_heatmaps_are_those_of_the_model_itself(
    started: torch.nn.Module, pictures: torch.Tensor
) -> None:
    model: object = started
    with torch.no_grad():
        ours = features(model, pictures)
        theirs = model.clip.get_image_features(  # type: ignore[attr-defined]
            pixel_values=pictures, interpolate_pos_encoding=True, output_hidden_states=True
        ).hidden_states
        for layer, own in zip(SMALL.extract, ours, strict=True):
            torch.testing.assert_close(own, theirs[layer + 1])
        conditions = torch.randn(8, SMALL.projection, generator=torch.Generator().manual_seed(2))
        repeated = tuple(layer.repeat_interleave(2, dim=0) for layer in ours)
        whole = model.decoder(repeated, conditions).logits  # type: ignore[attr-defined]
        torch.testing.assert_close(decode(model, ours, conditions), whole)
        loudness: list[torch.Tensor] = []
        part = decode(model, ours, conditions, (1, 0), 2, loudness)
        torch.testing.assert_close(part, whole[:, 1::2, ::2])
        decode(model, ours, 10.0 * conditions, loudness=loudness)
        first, second, louder, _ = [float(one) for one in loudness]
        assert min(first, second) > 0.0
        assert louder > 10.0 * first


def test_only_what_enters_a_layer_loudly_is_scaled_down(
    started: torch.nn.Module, pictures: torch.Tensor
) -> None:
    model = deepcopy(started)
    decoder: Any = model.decoder
    with torch.no_grad():
        seen = features(model, pictures)
        conditions = torch.randn(8, SMALL.projection, generator=torch.Generator().manual_seed(2))

        def loudness() -> list[float]:
            found: list[torch.Tensor] = []
            decode(model, seen, conditions, loudness=found)
            return [float(one) for one in found]

        before, calm = loudness(), deepcopy(decoder.state_dict())
        quieten(model, before)
        assert max(before) < LOUDEST
        torch.testing.assert_close(decoder.state_dict(), calm)

        for maker in (decoder.film_mul, decoder.film_add, decoder.reduces[1]):
            maker.weight.mul_(30.0)
            maker.bias.mul_(30.0)
        quieten(model, loudness())
        first, second = loudness()
    assert first == pytest.approx(LOUDEST, rel=1e-3)
    assert second < 1.5 * LOUDEST  # the layer before adds to it, which is normalised


def test_a_window_is_seen_where_it_lies_in_its_picture(
    started: torch.nn.Module, pictures: torch.Tensor
) -> None:
    """Far from the window's edge the first layer gives what it gives in the whole picture."""
    with torch.no_grad():
        whole = features(started, pictures)[0][:, 1:].reshape(-1, 8, 8, SMALL.width)
        corners = torch.tensor([[2, 3]] * len(pictures))
        part = features(started, pictures[:, :, 32:112, 48:128], corners)[0][:, 1:]
        elsewhere = features(started, pictures[:, :, 32:112, 48:128], corners * 0)[0][:, 1:]
    # The last dimensions say where a patch is.
    waves = 4 * wave_count(SMALL)
    there = part.reshape(-1, 5, 5, SMALL.width)[:, 2, 2, -waves:]
    assert float((there - whole[:, 4, 5, -waves:]).abs().max()) < 0.2
    assert float((elsewhere - part)[..., -waves:].abs().max()) > 1.0


def test_orthogonalised_matrices_have_singular_values_near_one() -> None:
    generator = torch.Generator().manual_seed(3)
    for shape in ((2, 16, 48), (1, 48, 16)):
        values = torch.linalg.svdvals(orthogonalised(torch.randn(shape, generator=generator)))
        assert 0.5 < float(values.min()) <= float(values.max()) < 1.3


def test_the_optimizer_goes_downhill_and_continues_bit_by_bit() -> None:
    def problem() -> tuple[torch.nn.Module, Optimizer]:
        torch.manual_seed(4)
        network = torch.nn.ModuleDict({"layers": torch.nn.Sequential(torch.nn.Linear(6, 6))})
        named = [(f"x.{name}", weight) for name, weight in network.named_parameters()]
        return network, Optimizer(named, 0.0)

    def go(network: torch.nn.Module, optimizer: Optimizer, steps: int) -> float:
        inputs = torch.eye(6)
        loss = torch.zeros(())
        for _ in range(steps):
            loss = (network.get_submodule("layers")(inputs) - torch.ones(6, 6)).square().mean()
            loss.backward()
            optimizer.step(0.03)
        return float(loss.detach())

    network, optimizer = problem()
    before = go(network, optimizer, 1)
    assert go(network, optimizer, 60) < 0.2 * before
    again, other = problem()
    go(again, other, 20)
    state = deepcopy(other.state_dict())
    third, last = problem()
    third.load_state_dict(again.state_dict())
    last.load_state_dict(state)
    assert go(third, last, 41) == go(again, other, 41)


def test_the_rate_rises_and_falls_with_what_is_done_of_the_plan() -> None:
    plan = Plan(steps=1000, warm_up=100, rate=1.0)
    rates = [learning_rate(plan, Progress(steps=n)) for n in (0, 99, 550, 999)]
    assert rates[0] == pytest.approx(0.01, abs=0.001)
    assert rates[1] > 0.95
    assert 0.3 < rates[2] < 0.7
    assert rates[3] < 0.02


def test_by_minutes_the_time_before_the_first_step_is_no_part_of_the_schedule() -> None:
    plan = Plan(minutes=60.0, closing_s=150.0)
    assert Progress(seconds=90.0, began=90.0).fraction(plan) == 0.0
    assert Progress(seconds=3450.0, began=90.0).fraction(plan) == 1.0
    assert Progress(seconds=10.0, began=9.0).fraction(Plan(minutes=0.1)) == 1.0
