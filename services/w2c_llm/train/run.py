"""One training run: data, tokenizer, network, loop, export, a check through llama.cpp, the card."""

import random
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

import torch

from w2c.clock import Clock, RealClock
from w2c.errors import ConfigError
from w2c_llm.train import checkpoint
from w2c_llm.train.batches import Mixture, mix
from w2c_llm.train.beginning import continued, final_layers, new, resumed
from w2c_llm.train.card import CardFacts, format_card, machine, training_commit
from w2c_llm.train.checkpoint import Checkpoint
from w2c_llm.train.data import Source, digest, encode_source, read_dialogues, read_source
from w2c_llm.train.device import Device, best_device
from w2c_llm.train.export import Card, export_gguf
from w2c_llm.train.growth import deepened
from w2c_llm.train.loop import Listeners, Progress, Recipe, Report, Trainer
from w2c_llm.train.origin import Origin
from w2c_llm.train.plan import TrainingPlan, TrainingResult
from w2c_llm.train.scoring import exact_matches, match_rates
from w2c_llm.train.tokenizer import EncodedExample
from w2c_llm.train.verification import verify_export

CHECKPOINT = "checkpoint.pt"
_SCORED_DURING_TRAINING = 200
_GROWS_AT = 1 / 3
"""Share of the budget at which a network grows"""

Log = Callable[[str], None]


class Run:
    """A run from its preparations to the card. `clock` counts the minutes."""

    def __init__(
        self,
        plan: TrainingPlan,
        log: Log,
        clock: Clock | None = None,
        device: Device | None = None,
    ) -> None:
        plan.check()
        self._plan, self._log = plan, log
        self._clock = clock or RealClock()
        self._started_ns = self._clock.now_ns()
        self._device = device or best_device()

    def __call__(self, stopped: Callable[[], bool] = lambda: False) -> TrainingResult | None:
        """Train, export, check, score. None when it was stopped: its checkpoint goes on.

        Raises:
            ConfigError: a file is missing or malformed, or there is nothing to resume.
            ModelError: the training diverged, or the exported file does not behave as the network.
            OSError: the model cannot be written.
        """
        torch.set_num_threads(self._plan.threads)
        self._plan.output.mkdir(parents=True, exist_ok=True)
        sources = self._sources()
        held_out = read_source(self._plan.heldout)
        kept = self._kept(sources)
        origin = self._origin(sources[0], kept)
        mixture = self._mixture(origin, sources)
        encoded_held_out = self._encode(origin, held_out)
        trainer = self._trainer(origin, kept)
        parameters = sum(weight.numel() for weight in origin.network.parameters())
        self._log(
            f"{parameters / 1e6:.2f} M parameters, {len(mixture.order)} examples an epoch, "
            f"{self._plan.threads} threads, {self._device.name}"
            f"{', bfloat16' if self._device.bf16 else ''}"
        )
        glimpse = random.Random(0).sample(  # noqa: S311 - not a secret
            encoded_held_out, min(_SCORED_DURING_TRAINING, len(encoded_held_out))
        )

        def train(origin: Origin, trainer: Trainer, until: float = 1.0) -> bool:
            listeners = Listeners(
                lambda report: self._report(report, trainer, glimpse),
                lambda: self._save(trainer, origin, sources),
                stopped,
            )
            return trainer.train(mixture, listeners, until)

        layers = final_layers(self._plan.shape, origin)
        if origin.size.layers < layers and train(origin, trainer, _GROWS_AT) and not stopped():
            origin = deepened(origin, layers)
            trainer = trainer.grown(origin.network)
            self._log(f"{layers} layers from here on")
        if origin.size.layers < layers or not train(origin, trainer):
            self._log(f"stopped; go on with --resume ({self._checkpoint_path})")
            return None
        return self._finish(trainer, origin, (*sources, held_out), mixture, encoded_held_out)

    @property
    def _checkpoint_path(self) -> Path:
        return self._plan.output / CHECKPOINT

    def _sources(self) -> tuple[Source, ...]:
        corpus = read_source(self._plan.corpus)
        if self._plan.dialogues is None:
            return (corpus,)
        return corpus, read_dialogues(self._plan.dialogues, self._log)

    def _identity(self, sources: Sequence[Source]) -> dict[str, str]:
        """Return what must not change in a run that is resumed. Time and rate may."""
        plan = self._plan
        identity = {
            "--corpus": sources[0].digest,
            "--seed": str(plan.seed),
            "--batch": str(plan.batch),
            "--with": "nothing",
            "--from": " ".join(digest(path) for path in plan.begin_with) or "nothing",
        }
        if plan.shape.begin_layers is not None:
            identity["--begin-layers"] = (
                f"{plan.shape.begin_layers}, growing to {plan.shape.new_layers}"
            )
        if plan.compiled:
            # Its sums are rounded otherwise: half a run of each would be neither.
            identity["--compile"] = "given"
        if plan.dialogues is not None:
            identity["--with"] = f"{sources[1].digest}, a share of {plan.dialogues_share:g}"
        return identity

    def _kept(self, sources: Sequence[Source]) -> Checkpoint | None:
        """Return the checkpoint of a run that is resumed."""
        if not self._plan.resume:
            return None
        path = self._checkpoint_path
        if not path.is_file():
            raise ConfigError(f"nothing to resume: no {path}; start without --resume")
        kept = checkpoint.load(path)
        checkpoint.expect_same(path, kept, self._identity(sources))
        return kept

    def _origin(self, corpus: Source, kept: Checkpoint | None) -> Origin:
        """Return network and tokenizer: of the run that is resumed, of `--from`, or new ones."""
        plan = self._plan
        if kept is not None:
            return resumed(self._checkpoint_path, plan.shape)
        if plan.begin_with:
            return continued(plan.begin_with, plan.shape)
        return new(corpus.examples, plan.shape, plan.seed)

    def _encode(self, origin: Origin, source: Source) -> list[EncodedExample]:
        encoded = encode_source(origin.tokenizer, source, origin.size.context, self._log)
        if not encoded:
            raise ConfigError(f"{source.name} holds no example that fits into the context")
        return encoded

    def _mixture(self, origin: Origin, sources: Sequence[Source]) -> Mixture:
        encoded = [self._encode(origin, source) for source in sources]
        others = encoded[1] if len(encoded) > 1 else []
        mixture = mix(encoded[0], others, self._plan.dialogues_share)
        if others:
            count = len(mixture.order) - len(encoded[0])
            self._log(
                f"{sources[1].name}: {count} of {len(mixture.order)} examples of an epoch "
                f"({count / len(mixture.order):.0%}), each {count / len(others):.1f} times"
            )
        return mixture

    def _trainer(self, origin: Origin, kept: Checkpoint | None) -> Trainer:
        plan = self._plan
        recipe = Recipe(
            minutes=plan.minutes,
            steps=plan.steps,
            batch=plan.batch,
            peak_rate=plan.rate,
            prompt_weight=plan.prompt_weight,
            dropout=plan.dropout,
            compiled=plan.compiled,
            seed=plan.seed,
        )
        trainer = Trainer(origin.network, recipe, self._clock, self._started_ns, self._device)
        if kept is not None:
            trainer.restore(kept.trainer)
        return trainer

    def _save(self, trainer: Trainer, origin: Origin, sources: Sequence[Source]) -> None:
        """Write a checkpoint. Without room for it the training goes on, with the one before."""
        content = Checkpoint(
            self._identity(sources), asdict(origin.size), origin.tokenizer.to_str(), trainer.state()
        )
        try:
            checkpoint.save(self._checkpoint_path, content)
        except OSError as error:
            self._log(f"no checkpoint written to {self._checkpoint_path}: {error.strerror}")

    def _report(self, report: Report, trainer: Trainer, glimpse: Sequence[EncodedExample]) -> None:
        progress = report.progress
        rates = match_rates(glimpse, exact_matches(trainer.network, glimpse, self._device))
        self._log(
            f"{progress.seconds / 60:5.1f} min  step {progress.step}  "
            f"examples {progress.examples}  rate {report.rate:.1e}  loss {report.loss:.4f}  "
            f"{_format(rates)}" + (f"  skipped {progress.skipped}" if progress.skipped else "")
        )

    def _finish(
        self,
        trainer: Trainer,
        origin: Origin,
        sources: Sequence[Source],
        mixture: Mixture,
        held_out: Sequence[EncodedExample],
    ) -> TrainingResult:
        """Write the model first: whatever fails after, it is there."""
        plan, progress = self._plan, trainer.progress
        path = plan.output / "model.gguf"
        description = f"trained on {progress.examples} examples, seed {plan.seed}"
        card = Card("words2contact-language", description)
        export_gguf(path, trainer.network, origin.tokenizer, card, plan.weights)
        rates = match_rates(held_out, exact_matches(trainer.network, held_out, self._device))
        self._log("held-out: " + _format(rates))
        difference = verify_export(
            path, trainer.network, origin.tokenizer, sources[-1].examples[:20]
        )
        size = origin.size
        facts = CardFacts(
            file=path.name,
            shape=f"{size.layers} layers, width {size.width}, {size.heads} heads, "
            f"feed-forward {size.feed_forward}",
            parameters=sum(weight.numel() for weight in trainer.network.parameters()),
            vocabulary=origin.tokenizer.get_vocab_size(),
            context=size.context,
            weights=plan.weights,
            megabytes=path.stat().st_size / 1e6,
            data=tuple(_describe(source) for source in sources),
            origin=_name_origins(plan.begin_with),
            recipe=f"Muon and AdamW, cosine from {plan.rate:g}, batches of {plan.batch}, "
            f"dropout {plan.dropout:g}{_growth(plan, progress)}",
            examples_seen=progress.examples,
            epochs=progress.examples / len(mixture.order),
            steps=progress.step,
            minutes=progress.seconds / 60.0,
            budget=plan.budget,
            seed=plan.seed,
            threads=plan.threads,
            processor=machine(self._device.name),
            commit=training_commit(),
            exact_match=rates,
            largest_logit_difference=difference,
        )
        card_path = plan.output / "README.md"
        card_path.write_text(format_card(facts))
        return TrainingResult(
            model_path=path,
            card_path=card_path,
            megabytes=facts.megabytes,
            parameters=facts.parameters,
            examples_seen=progress.examples,
            steps=progress.step,
            minutes=facts.minutes,
            exact_match=rates,
            largest_logit_difference=difference,
            seed=plan.seed,
        )


def _growth(plan: TrainingPlan, progress: Progress) -> str:
    if plan.shape.begin_layers is None:
        return ""
    return f"; {plan.shape.begin_layers} layers up to step {progress.grown_at}"


def _name_origins(paths: Sequence[Path]) -> str:
    names = [path.name for path in paths]
    if len(names) > 1:
        return f"the mean of {' and '.join(names)}"
    return names[0] if names else "random weights"


def _describe(source: Source) -> str:
    counts = ", ".join(f"{task} {count}" for task, count in source.counts().items())
    return f"`{source.name}` (SHA-256 `{source.digest}`), {len(source.examples)} examples: {counts}"


def _format(rates: dict[str, tuple[int, int]]) -> str:
    return "  ".join(f"{task} {right}/{total}" for task, (right, total) in rates.items())
