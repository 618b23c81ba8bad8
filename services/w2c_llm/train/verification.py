"""The exported file must behave as the network that was trained: same tokens, same logits."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from tokenizers import Tokenizer
from transformers import Qwen2ForCausalLM

from w2c.clock import RealClock
from w2c.errors import ModelError
from w2c_llm.backend import Budget
from w2c_llm.llama_model import LlamaModel
from w2c_llm.sequences import Sequences
from w2c_llm.train.corpus import Example
from w2c_llm.train.tokenizer import encode, render_prompt

_LARGEST_DIFFERENCE = 0.5
"""Of a logit, in standard deviations of all logits: 8-bit weights give about 0.1, a wrong
permutation or rotation gives several"""
_PATIENCE_S = 600.0


def verify_export(
    path: Path, network: Qwen2ForCausalLM, tokenizer: Tokenizer, examples: Sequence[Example]
) -> float:
    """Return the largest difference of a logit after the prompts of some examples.

    It is given in standard deviations of the logits, which grow with the training.

    Raises:
        ModelError: a prompt is tokenised differently, or the logits differ by more than
            quantization explains.
    """
    model = LlamaModel(path)
    sequences = Sequences(model, 1024, threads=1)
    torch.nn.Module.to(network, "cpu").train(False)
    worst = 0.0
    try:
        for example in examples:
            worst = max(worst, _difference(model, sequences, network, tokenizer, example))
    finally:
        sequences.close()
        model.close()
    if worst > _LARGEST_DIFFERENCE:
        raise ModelError(
            f"{path}: logits differ by {worst:.3f} standard deviations from those of the trained "
            f"network, limit {_LARGEST_DIFFERENCE}: the file is not to be used"
        )
    return worst


def _difference(
    model: LlamaModel,
    sequences: Sequences,
    network: Qwen2ForCausalLM,
    tokenizer: Tokenizer,
    example: Example,
) -> float:
    encoded = encode(tokenizer, example)
    prompt = encoded.tokens[: encoded.prompt_length].tolist()
    theirs = model.tokenize(render_prompt(example.messages), special=True)
    answer = model.tokenize(example.answer, special=False)
    if theirs != prompt or answer != encoded.tokens[encoded.prompt_length : -1].tolist():
        raise ModelError(f"llama.cpp tokenises differently: {theirs} against {prompt}")
    ours = sequences.begin(prompt, 0, 8, Budget(RealClock(), _PATIENCE_S)).logits
    with torch.no_grad():
        expected = network(input_ids=torch.tensor([prompt])).logits[0, -1].float().numpy()
    return float(np.abs(ours - expected).max() / expected.std())
