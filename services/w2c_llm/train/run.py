"""One training run: tokenizer, network, loop, score, export, and a check through llama.cpp."""

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import torch
from tokenizers import Tokenizer

from w2c.errors import ConfigError
from w2c_llm.train.corpus import Example, read_corpus
from w2c_llm.train.export import Card, Weights, export_gguf
from w2c_llm.train.loop import Recipe, Report, Trainer
from w2c_llm.train.network import NetworkSize, make_network
from w2c_llm.train.scoring import exact_matches, match_rates
from w2c_llm.train.tokenizer import EncodedExample, encode, train_tokenizer
from w2c_llm.train.verification import verify_export

_SCORED_DURING_TRAINING = 200
_TOKENIZER_EXAMPLES = 40_000
"""More than enough for the merges, and fast"""


@dataclass(frozen=True)
class TrainingPlan:
    """Everything a run depends on."""

    corpus: Path
    heldout: Path
    output: Path
    minutes: float = 40.0
    steps: int | None = None
    vocabulary: int = 2048
    layers: int = 4
    width: int = 256
    feed_forward: int = 704
    batch: int = 48
    peak_rate: float = 2e-3
    prompt_weight: float = 0.2
    threads: int = 1
    weights: Weights = "q8_0"
    seed: int = 0
    resume: bool = False


@dataclass(frozen=True)
class TrainingResult:
    """What a run gave."""

    model_path: Path
    megabytes: float
    parameters: int
    examples_seen: int
    exact_match: dict[str, tuple[int, int]]
    """Task -> (exact matches, examples) on the held-out file"""
    largest_logit_difference: float
    """Between transformers and llama.cpp, on held-out prompts"""
    seed: int


def run(plan: TrainingPlan, log: Callable[[str], None]) -> TrainingResult:
    """Train, score and export.

    Raises:
        ConfigError: a file is missing or malformed, or there is nothing to resume.
        ModelError: the exported file does not behave like the network.
    """
    torch.set_num_threads(plan.threads)
    plan.output.mkdir(parents=True, exist_ok=True)
    training, heldout = read_corpus(plan.corpus), read_corpus(plan.heldout)
    tokenizer = _tokenizer(plan, training)
    size = NetworkSize(plan.width, plan.layers, max(1, plan.width // 64), plan.feed_forward)
    encoded = _encode_all(tokenizer, training, size.context, log)
    encoded_heldout = _encode_all(tokenizer, heldout, size.context, log)
    network = make_network(size, tokenizer.get_vocab_size(), plan.seed)
    trainer = Trainer(network, _recipe(plan))
    checkpoint = plan.output / "checkpoint.pt"
    if plan.resume:
        if not checkpoint.is_file():
            raise ConfigError(f"nothing to resume: no {checkpoint}; start without --resume")
        trainer.restore(checkpoint)
    parameters = sum(weight.numel() for weight in network.parameters())
    log(f"{parameters / 1e6:.2f} M parameters, {len(encoded)} examples")
    glimpse = random.Random(0).sample(encoded_heldout, min(_SCORED_DURING_TRAINING, len(heldout)))  # noqa: S311 - not a secret

    def on_report(report: Report) -> None:
        trainer.save(checkpoint)
        rates = match_rates(glimpse, exact_matches(network, glimpse))
        log(_line(report, rates))

    trainer.train(encoded, on_report)
    rates = match_rates(encoded_heldout, exact_matches(network, encoded_heldout))
    log("held-out: " + _format(rates))
    model_path = plan.output / "model.gguf"
    card = Card("words2contact-language", f"trained on {trainer.progress.examples} examples")
    export_gguf(model_path, network, tokenizer, card, plan.weights)
    difference = verify_export(model_path, network, tokenizer, heldout[:20])
    return TrainingResult(
        model_path=model_path,
        megabytes=model_path.stat().st_size / 1e6,
        parameters=parameters,
        examples_seen=trainer.progress.examples,
        exact_match=rates,
        largest_logit_difference=difference,
        seed=plan.seed,
    )


def _recipe(plan: TrainingPlan) -> Recipe:
    return Recipe(
        minutes=plan.minutes,
        steps=plan.steps,
        batch=plan.batch,
        peak_rate=plan.peak_rate,
        prompt_weight=plan.prompt_weight,
        seed=plan.seed,
    )


def _tokenizer(plan: TrainingPlan, training: Sequence[Example]) -> Tokenizer:
    """Return the tokenizer of the run; a resumed run must keep the one it began with."""
    path = plan.output / "tokenizer.json"
    if plan.resume and path.is_file():
        return Tokenizer.from_file(str(path))
    sample = random.Random(plan.seed).sample(  # noqa: S311 - not a secret
        list(training), min(_TOKENIZER_EXAMPLES, len(training))
    )
    tokenizer = train_tokenizer(sample, plan.vocabulary)
    tokenizer.save(str(path))
    return tokenizer


def _encode_all(
    tokenizer: Tokenizer, examples: Sequence[Example], limit: int, log: Callable[[str], None]
) -> list[EncodedExample]:
    encoded = [encode(tokenizer, example) for example in examples]
    short = [example for example in encoded if len(example.tokens) <= limit]
    if len(short) < len(encoded):
        log(f"{len(encoded) - len(short)} examples are longer than {limit} tokens and left out")
    return short


def _line(report: Report, rates: dict[str, tuple[int, int]]) -> str:
    progress = report.progress
    return (
        f"{progress.seconds / 60:5.1f} min  step {progress.step}  examples {progress.examples}  "
        f"rate {report.rate:.1e}  loss {report.loss:.4f}  {_format(rates)}"
    )


def _format(rates: dict[str, tuple[int, int]]) -> str:
    return "  ".join(f"{task} {right}/{total}" for task, (right, total) in rates.items())
