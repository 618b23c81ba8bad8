"""A tiny model with random weights from the project's own exporter: the real loading path."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from w2c.clock import RealClock
from w2c.messages import ChatMessage
from w2c_llm.backend import Budget
from w2c_llm.llama_cpp_backend import LlamaCppBackend
from w2c_llm.train.corpus import Example, Turn
from w2c_llm.train.export import Card, export_gguf
from w2c_llm.train.network import NetworkSize, make_network
from w2c_llm.train.tokenizer import train_tokenizer

SENTENCE = "put your left hand on top of the red book next to the 12 mugs, a bit more to the right"
WORDS = SENTENCE.split()


def sample_examples() -> list[Example]:
    """Return a corpus that is only good for counting letters."""
    return [
        Example(
            [
                Turn("system", f"task {index % 3}"),
                Turn("user", " ".join(WORDS[index % 5 : index % 5 + 8])),
            ],
            f'{{"position":"{WORDS[index % 7]}","objects":["{index % 9}-{index % 9 + 1}"]}}',
        )
        for index in range(60)
    ]


@pytest.fixture(scope="session")
def tiny_model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the path of the model's file."""
    tokenizer = train_tokenizer(sample_examples(), 400)
    network = make_network(
        NetworkSize(width=64, layers=2, heads=2, feed_forward=128, context=512),
        tokenizer.get_vocab_size(),
        seed=3,
    )
    path = tmp_path_factory.mktemp("models") / "tiny.gguf"
    export_gguf(path, network, tokenizer, Card("tiny", "random weights"), "f16")
    return path


@pytest.fixture(scope="session")
def shared_backend(tiny_model: Path) -> Iterator[LlamaCppBackend]:
    """Return one backend for all tests that do not care what it has cached."""
    backend = LlamaCppBackend(tiny_model, context=2048, threads=1)
    yield backend
    backend.close()


@pytest.fixture
def fresh_backend(tiny_model: Path) -> Iterator[LlamaCppBackend]:
    """Return a backend that has seen nothing."""
    backend = LlamaCppBackend(tiny_model, context=1024, threads=1)
    yield backend
    backend.close()


@pytest.fixture
def budget() -> Budget:
    """Return a minute."""
    return Budget(RealClock(), 60.0)


@pytest.fixture
def chat() -> list[ChatMessage]:
    """Return a chat with one constant message."""
    return [
        ChatMessage(role="system", content="task 1"),
        ChatMessage(role="user", content="put your left hand on the red book"),
    ]
