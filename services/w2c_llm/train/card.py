"""The card of a model: what it is, what it was made of, what it cannot do."""

import os
import platform
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

SCORES_BEGIN, SCORES_END = "<!-- scores -->", "<!-- end -->"
"""`w2c evaluate language --card FILE` writes between them."""


@dataclass(frozen=True)
class CardFacts:
    """What a run knows of its model."""

    file: str
    shape: str
    """Layers, width, ..., in words"""
    parameters: int
    vocabulary: int
    context: int
    weights: str
    megabytes: float
    data: tuple[str, ...]
    """One line a file: name, digest, examples of each task"""
    origin: str
    """What it began with"""
    recipe: str
    examples_seen: int
    epochs: float
    steps: int
    minutes: float
    budget: str
    """`--minutes 60`, or `--steps 3000`"""
    seed: int
    threads: int
    processor: str
    commit: str
    exact_match: Mapping[str, tuple[int, int]]
    largest_logit_difference: float


def format_card(facts: CardFacts) -> str:
    """Return the card as Markdown."""
    rates = "\n".join(
        f"| {task} | {right} | {total} | {right / total:.3f} |"
        for task, (right, total) in facts.exact_match.items()
    )
    data = "\n".join(f"- {line}" for line in facts.data)
    return f"""# The language model `{facts.file}`

Trained by `w2c train language` for the prompts of `w2c_dialogue.prompts.embedded` only. It is no
chat model: asked anything else it answers nonsense (in the schema, as every model here).

| | |
|---|---|
| architecture | Qwen2: {facts.shape}, tied embedding; {facts.parameters / 1e6:.2f} M parameters |
| tokenizer | byte-level BPE, {facts.vocabulary} tokens, split `qwen2` with single digits |
| context | {facts.context} tokens |
| weights | {facts.weights}, {facts.megabytes:.1f} MB |
| began with | {facts.origin} |
| training | {facts.recipe} |
| seen | {facts.examples_seen} examples, {facts.epochs:.2f} epochs, {facts.steps} steps |
| time | {facts.minutes:.1f} minutes of `{facts.budget}`, {facts.threads} threads |
| hardware | {facts.processor} |
| seed | {facts.seed} |
| commit | `{facts.commit}` |
| license | Apache-2.0, as the repository |

## Data

{data}

The corpus was written by hand and drawn by `w2c_dialogue.corpus`; no text of it is from elsewhere.

## Scores

On sentences of people who took no part in the corpus:

{SCORES_BEGIN}
Not measured yet: `w2c evaluate language --model {facts.file} --card FILE` puts them here.
{SCORES_END}

Exact match (the whole answer, character by character, greedy, without any grammar) on drawn
sentences whose words were partly kept from training:

| task | right | of | rate |
|---|---|---|---|
{rates}

The exported file differs from the network that was trained by {facts.largest_logit_difference:.2f}
standard deviations of a logit at most.

## Limits

- English only; one sentence at a time; at most 60 words.
- It points at words and writes expressions of symbols. It sees no picture, and knows nothing of the
  world beyond what words say.
- What it answers is checked by the dialogue, shown to the operator and confirmed by a person. It is
  not to be used without.
"""


def training_commit() -> str:
    """Return the commit of this source, or `unknown` where it is installed without git."""
    try:
        answer = subprocess.run(
            ["git", "describe", "--always", "--dirty"],
            cwd=Path(__file__).parent,
            capture_output=True,
            text=True,
            check=True,
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return answer.stdout.strip()


def machine(processor: str) -> str:
    """Return processor, cores and system in one line."""
    return f"{processor}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}"
