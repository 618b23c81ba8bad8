"""`w2c train grounding`: make the embedded model from pictures."""

import sys
import time
from pathlib import Path
from typing import Annotated, Any

import msgspec

from w2c.config import parse
from w2c.errors import ConfigError
from w2c.extras import needs_extra
from w2c_grounding.card import ModelCard, write_card
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import load


class TrainConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Train a small CLIPSeg on pictures of `w2c scenes render`.

    Writes OUT/checkpoint (what `w2c grounding --model` reads), OUT/scores.json and OUT/state.pt
    (for --resume). One picture in twenty of --data is not trained on: the threshold is calibrated
    there.
    """

    data: str
    """Directory of pictures to train on."""
    out: str
    """Directory for the results."""
    judge: str = ""
    """Directory of pictures to score on; empty = those kept from --data."""
    minutes: Annotated[float, msgspec.Meta(gt=0)] = 40.0
    """Processor time for training, earlier parts of a resumed one included."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    """Of weights, order, questions and changes to pictures."""
    threads: Annotated[int, msgspec.Meta(ge=1, le=256)] = 2
    """CPU threads."""
    resume: bool = False
    """Continue from OUT/state.pt, with the pictures that are there now."""
    name: str = "w2c-clipseg-1"
    """Of the model, in its card and its replies."""


def train(arguments: list[str] | None = None) -> int:
    """Run the verb. Exit status: 0 done, 1 failed, 2 usage."""
    argv = sys.argv[1:] if arguments is None else arguments
    config = parse(TrainConfig, argv, program="w2c train grounding")
    with needs_extra("train"):
        import torch

        from w2c_grounding.train.data import load_pictures, truth_files
        from w2c_grounding.train.model import Size, save
    torch.set_num_threads(config.threads)
    torch.manual_seed(config.seed)
    out = Path(config.out)
    out.mkdir(parents=True, exist_ok=True)
    files = truth_files(Path(config.data))
    kept = files[::20]
    used = [path for path in files if path not in set(kept)]
    if not used:
        raise ConfigError(
            f"{config.data} holds {len(files)} pictures; training needs more than that"
        )
    size = Size()
    print(f"{len(used)} pictures to train on, {len(kept)} to calibrate on", flush=True)
    started = time.monotonic()
    pictures = load_pictures(used, size.image)
    print(f"read in {time.monotonic() - started:.0f} s", flush=True)
    trainer, processor, vocabulary = _prepare(config, pictures, size)
    trainer.run(out / "state.pt", lambda line: print(line, flush=True))
    judged = truth_files(Path(config.judge)) if config.judge else kept
    card = ModelCard(name=config.name, vocabulary=vocabulary)
    save(trainer.averaged(), processor, card, out / "checkpoint")
    scores = _measure(config, card, kept, judged)
    scores |= {"minutes": trainer.seconds / 60, "steps": trainer.steps, "pictures": len(used)}
    encoded = msgspec.json.format(msgspec.json.encode(scores), indent=1)
    (out / "scores.json").write_bytes(encoded + b"\n")
    print(encoded.decode())
    return 0


def _prepare(config: TrainConfig, pictures: Any, size: Any) -> tuple[Any, Any, list[str]]:
    """Return the trainer, the processor and the vocabulary."""
    import torch

    from w2c_grounding.train.augment import normalise
    from w2c_grounding.train.model import new_model, new_processor, start_patches
    from w2c_grounding.train.phrases import tokenizer_words, vocabulary_of
    from w2c_grounding.train.trainer import Plan, Trainer

    vocabulary = vocabulary_of(pictures.truths)
    processor = new_processor(size, tokenizer_words(vocabulary))
    model = new_model(size, len(processor.tokenizer))
    some = torch.from_numpy(pictures.pixels[:: max(1, len(pictures) // 64)]).permute(0, 3, 1, 2)
    start_patches(model, normalise(some.float() / 255.0))
    plan = Plan(minutes=config.minutes, seed=config.seed)
    trainer = Trainer(model, processor, pictures, size, plan)
    if config.resume:
        trainer.resume(Path(config.out) / "state.pt")
    return trainer, processor, vocabulary


def _measure(
    config: TrainConfig, card: ModelCard, kept: list[Path], judged: list[Path]
) -> dict[str, float]:
    """Calibrate the threshold of OUT/checkpoint on what was kept back, note it there, and score."""
    from w2c_grounding.train.score import calibrate, run_trials, summarise

    directory = Path(config.out) / "checkpoint"
    family, _ = load(ModelConfig(model=str(directory), threads=config.threads))
    threshold = calibrate(run_trials(family, kept, config.seed))
    write_card(msgspec.structs.replace(card, threshold=threshold), directory)
    scores = summarise(run_trials(family, judged, config.seed), threshold)
    return {"threshold": threshold, "judged_pictures": float(len(judged)), **scores}
