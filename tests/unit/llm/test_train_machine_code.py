"""A compiled network teaches as the other does; without a compiler it says so."""

import shutil
import sysconfig
from pathlib import Path

import pytest
import torch
from torch._dynamo.exc import TorchDynamoException
from torch._dynamo.utils import counters

from w2c.clock import StepClock
from w2c.errors import ConfigError
from w2c_llm.train.batches import mix
from w2c_llm.train.corpus import Example, Turn
from w2c_llm.train.loop import Listeners, Recipe, Trainer
from w2c_llm.train.machine_code import as_machine_code, compiling
from w2c_llm.train.network import NetworkSize, make_network
from w2c_llm.train.tokenizer import encode_all, train_tokenizer

EXAMPLES = [Example([Turn("user", f"say {word}")], word) for word in ("cup", "a mug now", "pen")]
TOKENIZER = train_tokenizer(EXAMPLES, 300)
SIZE = NetworkSize(width=64, layers=1, heads=2, feed_forward=64, context=128)
HAS_COMPILER = (
    shutil.which("g++") is not None
    and (Path(sysconfig.get_paths()["include"]) / "Python.h").is_file()
)


def trained(*, compiled: bool) -> dict[str, torch.Tensor]:
    network = make_network(SIZE, TOKENIZER.get_vocab_size(), 3)
    recipe = Recipe(minutes=1.0, steps=3, batch=2, peak_rate=1e-3, dropout=0.2, compiled=compiled)
    trainer = Trainer(network, recipe, StepClock(), 0)
    mixture = mix(list(encode_all(TOKENIZER, EXAMPLES)), [], 0.2)
    assert trainer.train(mixture, Listeners(lambda _: None, lambda: None))
    return network.state_dict()


# Of what the compiler itself does.
@pytest.mark.filterwarnings("ignore")
@pytest.mark.skipif(not HAS_COMPILER, reason="needs g++ and Python's headers (python3-dev)")
def test_a_compiled_network_learns_the_same() -> None:
    counters.clear()
    compiled = trained(compiled=True)
    assert counters["stats"]["unique_graphs"] >= 1
    assert not counters["graph_break"]
    for name, weight in trained(compiled=False).items():
        torch.testing.assert_close(compiled[name], weight, rtol=1e-3, atol=1e-4)


def test_without_a_compiler_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(ConfigError, match=r"found no no-such-compiler: install one .*g\+\+"):
        as_machine_code(torch.nn.Linear(2, 2))


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (
            "CppCompileError\n\nx.cpp:1: fatal error: Python.h: No such file",
            "fatal error: Python.h",
        ),
        ("no graph for this", "no graph for this"),
        ("", "TorchDynamoException"),
    ],
)
def test_what_cannot_be_compiled_says_why(message: str, reason: str) -> None:
    with pytest.raises(ConfigError, match=rf"\(.*{reason}.*\).*python3-dev"), compiling():
        raise TorchDynamoException(message)
