"""A training that is killed, starved of disk or of time goes on, and says what it cannot do."""

import os
import signal
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from w2c.clock import StepClock
from w2c.errors import ConfigError, ModelError
from w2c_llm.train import checkpoint
from w2c_llm.train.batches import Mixture, mix
from w2c_llm.train.checkpoint import Checkpoint
from w2c_llm.train.corpus import Example, Turn
from w2c_llm.train.export import Card, export_gguf
from w2c_llm.train.growth import deepened
from w2c_llm.train.interruption import interruptible
from w2c_llm.train.loop import Listeners, Recipe, Report, Trainer
from w2c_llm.train.mean import read_origins
from w2c_llm.train.network import NetworkSize, make_network
from w2c_llm.train.optimizer import orthogonalised
from w2c_llm.train.origin import Origin, read_origin
from w2c_llm.train.plan import Shape, TrainingPlan
from w2c_llm.train.run import CHECKPOINT, Run
from w2c_llm.train.tokenizer import encode_all, train_tokenizer

SIZE = NetworkSize(width=64, layers=1, heads=2, feed_forward=64, context=128)
WORDS = ("cup", "mug", "book", "pen", "lamp", "box", "tray")
EXAMPLES = [
    Example([Turn("system", "t"), Turn("user", f"say {word} now")], f'{{"word":"{word}"}}')
    for word in WORDS
]
TOKENIZER = train_tokenizer(EXAMPLES, 300)


class BusyClock(StepClock):
    """A clock on which every look takes a while."""

    def __init__(self, each_s: float) -> None:
        super().__init__()
        self._each_ns = int(each_s * 1e9)

    def now_ns(self) -> int:
        self.set(super().now_ns() + self._each_ns)
        return super().now_ns()


@pytest.fixture(scope="module")
def mixture() -> Mixture:
    torch.set_num_threads(1)
    return mix(list(encode_all(TOKENIZER, EXAMPLES)), [], 0.2)


def trainer(recipe: Recipe, seed: int = 0, each_s: float = 1.0) -> Trainer:
    network = make_network(SIZE, TOKENIZER.get_vocab_size(), seed)
    return Trainer(network, recipe, BusyClock(each_s), 0)


def listeners(stop_after: int = 10**9) -> Listeners:
    asked = iter(range(1, 10**9))
    return Listeners(lambda _: None, lambda: None, lambda: next(asked) >= stop_after)


def same_weights(one: Trainer, other: Trainer) -> bool:
    mine, theirs = one.network.state_dict(), other.network.state_dict()
    return all(torch.equal(mine[name], theirs[name]) for name in mine)


@pytest.mark.parametrize("dropout", [0.0, 0.2])
def test_killed_and_resumed_gives_the_same_weights_as_uninterrupted(
    mixture: Mixture, tmp_path: Path, dropout: float
) -> None:
    recipe = Recipe(minutes=1.0, steps=9, batch=3, dropout=dropout)
    whole = trainer(recipe)
    assert whole.train(mixture, listeners())
    # 4 steps: in the middle of the second epoch of three batches.
    killed = trainer(recipe)
    assert not killed.train(mixture, listeners(stop_after=4))
    path = tmp_path / "checkpoint.pt"
    checkpoint.save(path, Checkpoint({}, {}, "", killed.state()))
    resumed = trainer(recipe, seed=5)
    resumed.restore(checkpoint.load(path).trainer)
    assert resumed.train(mixture, listeners())
    assert resumed.progress.step == 9
    assert resumed.progress.examples == whole.progress.examples == 21
    assert same_weights(resumed, whole)
    assert not same_weights(killed, whole)


def test_a_checkpoint_comes_every_few_minutes_and_the_time_ends_the_run(mixture: Mixture) -> None:
    recipe = Recipe(minutes=30.0, batch=3, checkpoint_s=240.0, report_s=300.0)
    busy = trainer(recipe, each_s=50.0)
    saved: list[float] = []
    reports: list[Report] = []
    finished = busy.train(
        mixture, Listeners(reports.append, lambda: saved.append(busy.progress.seconds))
    )
    assert finished
    steps_apart = [later - earlier for earlier, later in zip([50.0, *saved], saved, strict=False)]
    assert max(steps_apart) <= 300.0
    assert recipe.last_s == 29 * 60
    assert recipe.last_s <= busy.progress.seconds < recipe.last_s + 50.0
    assert reports[-1].rate == pytest.approx(recipe.peak_rate * 0.02)
    assert saved[-1] == busy.progress.seconds, "the end is kept too"


def test_the_time_before_a_kill_counts(mixture: Mixture) -> None:
    recipe = Recipe(minutes=30.0, batch=3)
    killed = trainer(recipe, each_s=60.0)
    assert not killed.train(mixture, listeners(stop_after=10))
    resumed = trainer(recipe, each_s=60.0)
    resumed.restore(killed.state())
    spent = killed.progress.step
    assert resumed.train(mixture, listeners())
    assert resumed.progress.seconds < recipe.last_s + 60.0
    assert 15 <= resumed.progress.step - spent <= 20


def test_a_gradient_that_is_never_finite_ends_the_run(mixture: Mixture) -> None:
    broken = trainer(Recipe(minutes=1.0, steps=99, batch=3))
    before = {name: weight.clone() for name, weight in broken.network.state_dict().items()}
    broken.network.model.norm.weight.data[0] = float("nan")
    with pytest.raises(ModelError, match=r"finite gradient in 21 of 21 steps.*lower --rate"):
        broken.train(mixture, listeners())
    name = "model.layers.0.mlp.up_proj.weight"
    assert torch.equal(before[name], broken.network.state_dict()[name]), "nothing was changed"


def test_updates_have_singular_values_near_one() -> None:
    generator = torch.Generator().manual_seed(0)
    for shape in ((3, 64, 64), (2, 64, 192), (2, 192, 64)):
        matrices = torch.randn(shape, generator=generator)
        values = torch.linalg.svdvals(orthogonalised(matrices))
        assert values.shape[-1] == 64
        assert float(values.median()) == pytest.approx(0.95, abs=0.25)
        assert float(values.max()) < 1.3


def plan(folder: Path, **changes: object) -> TrainingPlan:
    corpus = folder / "corpus.jsonl"
    corpus.write_text(
        "\n".join(
            f'{{"messages":[{{"role":"user","content":"say {word}"}}],"answer":"{word}"}}'
            for word in WORDS
        )
    )
    shape = Shape(layers=1, width=64, feed_forward=64, vocabulary=300)
    standard = {"output": folder / "run", "shape": shape, "threads": 1, "steps": 2, "batch": 3}
    return TrainingPlan(corpus=corpus, heldout=corpus, **{**standard, **changes})  # type: ignore[arg-type]  # fields by name


def test_a_full_disk_ends_no_training(tmp_path: Path) -> None:
    (tmp_path / "run" / "checkpoint.partial").mkdir(parents=True)
    lines: list[str] = []
    result = Run(plan(tmp_path), lines.append)(lambda: False)
    assert result is not None
    assert result.model_path.is_file()
    assert any(line.startswith("no checkpoint written") for line in lines)


def test_a_stopped_run_is_resumed_with_what_it_began_with(tmp_path: Path) -> None:
    lines: list[str] = []
    assert Run(plan(tmp_path), lines.append)(lambda: True) is None
    assert "--resume" in lines[-1]
    assert not (tmp_path / "run" / "model.gguf").exists()
    for changes, flag in (({"seed": 1}, "--seed was 0, now 1"), ({"batch": 4}, "--batch was 3")):
        with pytest.raises(ConfigError, match=flag):
            Run(plan(tmp_path, resume=True, **changes), lines.append)()
    assert Run(plan(tmp_path, resume=True), lines.append)() is not None


@pytest.mark.parametrize("content", [b"GGUF", b"GGUF" + bytes(64), b"", b"not a model", b"PK\3\4"])
def test_what_is_no_model_is_nothing_to_begin_with(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match="file"):
        read_origin(path)
    with pytest.raises(ConfigError, match="cannot be read"):
        read_origin(tmp_path / "missing")


def test_a_gguf_file_gives_back_weights_and_tokenizer(tmp_path: Path) -> None:
    network = make_network(SIZE, TOKENIZER.get_vocab_size(), 7)
    path = tmp_path / "model.gguf"
    export_gguf(path, network, TOKENIZER, Card("t", "t"), "f32")
    origin = read_origin(path)
    assert origin.size == SIZE
    for name, weight in network.state_dict().items():
        assert torch.equal(weight, origin.network.state_dict()[name]), name
    assert origin.network.lm_head.weight is origin.network.model.embed_tokens.weight
    for text in ("say cup now", "<|user|>Say 12 cups!<|end|><|assistant|>", "é\n\t左 'll"):
        assert origin.tokenizer.encode(text).ids == TOKENIZER.encode(text).ids
        ids = TOKENIZER.encode(text).ids
        assert origin.tokenizer.decode(ids) == TOKENIZER.decode(ids)


def test_a_run_begins_with_a_checkpoint_of_another(tmp_path: Path) -> None:
    lines: list[str] = []
    assert Run(plan(tmp_path), lines.append)() is not None
    other = plan(
        tmp_path,
        output=tmp_path / "other",
        begin_with=(tmp_path / "run" / CHECKPOINT,),
        shape=Shape(),
        steps=1,
    )
    assert Run(other, lines.append)() is not None
    assert "began with | checkpoint.pt" in (tmp_path / "other" / "README.md").read_text()
    with pytest.raises(ConfigError, match="--vocabulary is 299"):
        Run(
            plan(
                tmp_path, begin_with=(tmp_path / "run" / CHECKPOINT,), shape=Shape(vocabulary=299)
            ),
            print,
        )()


def test_a_run_begins_with_the_mean_of_several(tmp_path: Path) -> None:
    networks = [make_network(SIZE, TOKENIZER.get_vocab_size(), seed) for seed in (7, 8, 9)]
    paths = [tmp_path / f"{number}.gguf" for number in range(3)]
    for path, network in zip(paths, networks, strict=True):
        export_gguf(path, network, TOKENIZER, Card("t", "t"), "f32")
    mean = read_origins(paths).network.state_dict()
    for name, weight in mean.items():
        expected = torch.stack([network.state_dict()[name] for network in networks]).mean(dim=0)
        torch.testing.assert_close(weight, expected)
    assert read_origins(paths[:1]).network.state_dict().keys() == mean.keys()

    wider = make_network(replace(SIZE, feed_forward=128), TOKENIZER.get_vocab_size(), 1)
    export_gguf(tmp_path / "wider.gguf", wider, TOKENIZER, Card("t", "t"), "f32")
    with pytest.raises(ConfigError, match=r"wider\.gguf has another size or tokenizer"):
        read_origins([paths[0], tmp_path / "wider.gguf"])


def test_a_training_and_the_shallower_one_it_grew_from_have_a_mean(tmp_path: Path) -> None:
    shallow = Origin(make_network(SIZE, TOKENIZER.get_vocab_size(), 1), TOKENIZER, SIZE)
    deep = deepened(shallow, 2)
    for weight in deep.network.parameters():
        weight.data += 0.5
    paths = [tmp_path / "shallow.gguf", tmp_path / "deep.gguf"]
    for path, origin in zip(paths, (shallow, deep), strict=True):
        export_gguf(path, origin.network, TOKENIZER, Card("t", "t"), "f32")
    mean = read_origins(paths, 2)
    assert mean.size.layers == 2
    before = deepened(shallow, 2).network.state_dict()
    for name, weight in mean.network.state_dict().items():
        torch.testing.assert_close(weight, before[name] + 0.25)

    with pytest.raises(ConfigError, match=r"deep\.gguf has another size .*--layers if they differ"):
        read_origins(paths)


def test_dialogues_of_the_user_are_mixed_in(tmp_path: Path) -> None:
    mine = tmp_path / "mine.jsonl"
    mine.write_text('{"utterance": "a bit left", "module": "correction", "objects": []}\n')
    lines: list[str] = []
    mixed = plan(tmp_path, dialogues=mine, dialogues_share=0.3, steps=1)
    assert Run(mixed, lines.append)() is not None
    assert "mine.jsonl: 1 turns, 2 questions" in lines
    assert "mine.jsonl: 3 of 10 examples of an epoch (30%), each 1.5 times" in lines
    assert "`mine.jsonl` (SHA-256" in (tmp_path / "run" / "README.md").read_text()
    mine.write_text('{"utterance": "a bit left"}\n')
    with pytest.raises(ConfigError, match=r"line 1: .*`module`"):
        Run(mixed, lines.append)()


def test_a_signal_ends_a_run_at_its_next_step() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with interruptible() as stopped:
        assert not stopped()
        os.kill(os.getpid(), signal.SIGTERM)
        assert stopped()
        assert signal.getsignal(signal.SIGTERM) == before, "the next one ends the process"
    assert signal.getsignal(signal.SIGTERM) == before
