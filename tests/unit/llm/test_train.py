"""Corpus to GGUF in miniature: little is learned; that the parts fit is the point."""

import json
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from tokenizers import Tokenizer

from w2c.clock import RealClock
from w2c.errors import ConfigError, ModelError
from w2c_llm.llama_model import LlamaModel
from w2c_llm.train.batches import epoch_groups, make_batch, mix
from w2c_llm.train.card import SCORES_BEGIN, SCORES_END
from w2c_llm.train.commands import train
from w2c_llm.train.corpus import Example, Turn, read_corpus
from w2c_llm.train.export import Card, export_gguf
from w2c_llm.train.loop import Listeners, Recipe, Trainer, learning_rate
from w2c_llm.train.network import NetworkSize, make_network
from w2c_llm.train.scoring import exact_matches, match_rates
from w2c_llm.train.tokenizer import EncodedExample, encode, train_tokenizer
from w2c_llm.train.verification import verify_export

SIZE = NetworkSize(width=64, layers=1, heads=2, feed_forward=64, context=128)


def example(words: str, answer: str, task: str = "t") -> Example:
    return Example([Turn("system", task), Turn("user", words)], answer, task)


EXAMPLES = [
    example(f"say {word} now", f'{{"word":"{word}"}}') for word in ("cup", "mug", "book", "pen")
]


@pytest.fixture(scope="module")
def tokenizer() -> Tokenizer:
    return train_tokenizer(EXAMPLES, 300)


@pytest.fixture(scope="module")
def encoded(tokenizer: Tokenizer) -> list[EncodedExample]:
    return [encode(tokenizer, one) for one in EXAMPLES]


def test_a_line_that_is_no_example_is_named(tmp_path: Path) -> None:
    path = tmp_path / "corpus.jsonl"
    good = '{"messages":[{"role":"user","content":"x"}],"answer":"y"}'
    path.write_text(good + "\n\n" + good.replace('"y"', "3") + "\n")
    with pytest.raises(ConfigError, match="line 3"):
        read_corpus(path)
    path.write_text(good)
    assert read_corpus(path)[0].answer == "y"
    path.write_text("")
    with pytest.raises(ConfigError, match="no example"):
        read_corpus(path)
    with pytest.raises(ConfigError, match="no corpus"):
        read_corpus(tmp_path / "missing")


@settings(max_examples=200)
@given(text=st.text(max_size=60) | st.text("a '9\n\t\r.-{}\"é左", max_size=60))
def test_llama_cpp_splits_texts_as_training_does(
    tiny_llama: tuple[LlamaModel, Tokenizer], text: str
) -> None:
    model, tokenizer = tiny_llama
    if any(token in text for token in model.control_texts):
        return
    expected = tokenizer.encode(text, add_special_tokens=False).ids
    assert model.tokenize(text, special=False) == expected
    assert model.detokenize(expected) == text


@pytest.fixture(scope="module")
def tiny_llama(
    tmp_path_factory: pytest.TempPathFactory, tokenizer: Tokenizer
) -> tuple[LlamaModel, Tokenizer]:
    path = tmp_path_factory.mktemp("export") / "model.gguf"
    network = make_network(SIZE, tokenizer.get_vocab_size(), 0)
    export_gguf(path, network, tokenizer, Card("t", "t"), "f32")
    return LlamaModel(path), tokenizer


def test_digits_are_single_tokens(tokenizer: Tokenizer) -> None:
    assert tokenizer.encode("1234567890").tokens == list("1234567890")


def test_the_loss_counts_the_answer_and_its_end_only(encoded: list[EncodedExample]) -> None:
    batch = make_batch(encoded, prompt_weight=0.0)
    for row, one in enumerate(encoded):
        counted = batch.targets[row][batch.weights[row] > 0].tolist()
        assert counted == one.tokens[one.prompt_length :].tolist()
        assert batch.targets[row][batch.answers[row]].tolist() == counted


def test_an_epoch_holds_every_example_once_in_an_order_of_its_own(
    encoded: list[EncodedExample],
) -> None:
    mixture = mix(encoded * 31, [], 0.2)
    first, second = (np.concatenate(epoch_groups(mixture, 5, 0, epoch)) for epoch in (0, 1))
    assert sorted(first) == list(range(len(mixture.examples)))
    assert sorted(second) == sorted(first)
    assert list(second) != list(first)


def test_others_make_up_their_share_of_an_epoch(encoded: list[EncodedExample]) -> None:
    mixture = mix(encoded * 20, encoded[:3], 0.2)
    order = np.concatenate(epoch_groups(mixture, 5, 0, 0))
    others = order[order >= 80]
    assert len(others) / len(order) == pytest.approx(0.2)
    assert np.ptp(np.unique(others, return_counts=True)[1]) <= 1, "each about as often"


def test_the_rate_rises_then_falls_to_a_fiftieth() -> None:
    recipe = Recipe(minutes=1.0, peak_rate=1.0, warm_up=0.1)
    rates = [learning_rate(recipe, fraction) for fraction in np.linspace(0.0, 1.0, 101)]
    assert max(rates) == pytest.approx(1.0)
    assert rates.index(max(rates)) == 10
    assert rates[-1] == pytest.approx(0.02)


def quiet() -> Listeners:
    return Listeners(report=lambda _: None, checkpoint=lambda: None)


def test_a_network_learns_four_words_and_the_exported_file_knows_them(
    tokenizer: Tokenizer, encoded: list[EncodedExample], tmp_path: Path
) -> None:
    torch.set_num_threads(1)
    network = make_network(SIZE, tokenizer.get_vocab_size(), 0)
    assert not all(exact_matches(network, encoded))
    recipe = Recipe(minutes=9.0, steps=80, batch=4, peak_rate=2e-2, prompt_weight=0.0)
    assert Trainer(network, recipe, RealClock(), 0).train(mix(encoded, [], 0.2), quiet())
    matches = exact_matches(network, encoded)
    assert match_rates(encoded, matches) == {"all": (4, 4), "t": (4, 4)}
    path = tmp_path / "model.gguf"
    export_gguf(path, network, tokenizer, Card("words", "four"), "f32")
    assert verify_export(path, network, tokenizer, EXAMPLES) < 0.01
    other = make_network(SIZE, tokenizer.get_vocab_size(), 1)
    with pytest.raises(ModelError, match="logits differ"):
        verify_export(path, other, tokenizer, EXAMPLES)


def test_the_command_trains_scores_exports_and_resumes(tmp_path: Path) -> None:
    corpus = tmp_path / "corpus.jsonl"
    lines = [
        {
            "messages": [{"role": t.role, "content": t.content} for t in one.messages],
            "answer": one.answer,
            "task": one.task,
        }
        for one in EXAMPLES
    ]
    corpus.write_text("\n".join(map(json.dumps, lines)))
    flags = ["--corpus", str(corpus), "--heldout", str(corpus), "--out", str(tmp_path / "run")]
    shape = ["--width", "64", "--layers", "1", "--feed-forward", "64", "--vocabulary", "300"]
    flags += ["--threads", "1"]
    assert train([*flags, *shape, "--steps", "2", "--resume"]) == 2, "nothing to resume yet"
    assert train([*flags, *shape, "--steps", "2", "--json", str(tmp_path / "result.json")]) == 0
    assert train([*flags, "--steps", "3", "--resume"]) == 0, "the shape is that of the checkpoint"
    assert train([*flags, "--steps", "3", "--resume", "--seed", "1"]) == 2, "another run"
    rows = json.loads((tmp_path / "result.json").read_text())["rows"]
    assert {row["case"]: row["n"] for row in rows} == {"all": 4, "t": 4, "run": 1}
    model = tmp_path / "run" / "model.gguf"
    assert model.stat().st_size > 10_000
    card = (tmp_path / "run" / "README.md").read_text()
    assert "`corpus.jsonl` (SHA-256" in card
    assert SCORES_BEGIN in card
    assert SCORES_END in card.partition(SCORES_BEGIN)[2]
    flags[5] = str(tmp_path / "second")
    assert train([*flags, "--from", str(model), "--steps", "1"]) == 0
    assert train([*flags, "--from", str(model), "--steps", "1", "--width", "128"]) == 2
    assert train([*flags, "--from", str(model), "--steps", "1", "--layers", "2"]) == 0
    assert "2 layers, width 64" in (tmp_path / "second" / "README.md").read_text()
    assert train(["--corpus", "no", "--heldout", "no", "--out", str(tmp_path / "x")]) == 2


@pytest.mark.parametrize("flag", ["--minutes=0", "--batch=0", "--width=100", "--with-share=1"])
def test_numbers_that_cannot_be_are_refused(flag: str, tmp_path: Path) -> None:
    assert train(["--corpus", "no", "--heldout", "no", "--out", str(tmp_path), flag]) == 2
