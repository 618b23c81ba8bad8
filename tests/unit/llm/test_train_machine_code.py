"""A compiled network teaches as the other does; without a compiler it says so."""

import shutil

import pytest
import torch

from w2c.clock import StepClock
from w2c.errors import ConfigError
from w2c_llm.train import machine_code
from w2c_llm.train.batches import mix
from w2c_llm.train.corpus import Example, Turn
from w2c_llm.train.loop import Listeners, Recipe, Trainer
from w2c_llm.train.machine_code import MachineCode
from w2c_llm.train.network import NetworkSize, make_network
from w2c_llm.train.tokenizer import encode_all, train_tokenizer

EXAMPLES = [Example([Turn("user", f"say {word}")], word) for word in ("cup", "a mug now", "pen")]
TOKENIZER = train_tokenizer(EXAMPLES, 300)
SIZE = NetworkSize(width=64, layers=1, heads=2, feed_forward=64, context=128)


def trained(*, compiled: bool) -> dict[str, torch.Tensor]:
    network = make_network(SIZE, TOKENIZER.get_vocab_size(), 3)
    recipe = Recipe(minutes=1.0, steps=3, batch=1, peak_rate=1e-3, dropout=0.2, compiled=compiled)
    trainer = Trainer(network, recipe, StepClock(), 0)
    mixture = mix(list(encode_all(TOKENIZER, EXAMPLES)), [], 0.2)
    assert trainer.train(mixture, Listeners(lambda _: None, lambda: None))
    return network.state_dict()


# Of what the compiler itself does.
@pytest.mark.filterwarnings("ignore")
@pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler (g++)")
def test_a_compiled_network_learns_the_same() -> None:
    compiled = trained(compiled=True)
    for name, weight in trained(compiled=False).items():
        torch.testing.assert_close(compiled[name], weight, rtol=1e-3, atol=1e-4)


def test_without_a_compiler_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_code, "_COMPILER", "no-such-compiler")
    with pytest.raises(ConfigError, match=r"found no no-such-compiler: install one .*g\+\+"):
        MachineCode(torch.nn.Linear(2, 2))
