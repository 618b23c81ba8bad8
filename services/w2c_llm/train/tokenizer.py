"""The byte-level BPE of the embedded model, and how a chat becomes tokens.

The split before BPE is the one that llama.cpp calls `qwen2`; it keeps digits single, which makes
numbers easy to copy. What is trained here must be tokenised identically there: a test compares the
two.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
import numpy.typing as npt
from tokenizers import Regex, Tokenizer, decoders, models, pre_tokenizers, trainers

from w2c.errors import ConfigError
from w2c_llm.train.corpus import Example, Turn

PRE_TOKENIZER = "qwen2"
SPLIT = (
    r"(?i:'s|'t|'re|'ve|'m|'ll|'d)|[^\r\n\p{L}\p{N}]?\p{L}+|\p{N}| ?[^\s\p{L}\p{N}]+[\r\n]*"
    r"|\s*[\r\n]+|\s+(?!\S)|\s+"
)

_BLOCK = 4096
"""Examples that are encoded at once, on all cores"""

PAD = "<|pad|>"
END = "<|end|>"
ROLES = ("system", "user", "assistant")
SPECIAL_TOKENS = (PAD, END, *(f"<|{role}|>" for role in ROLES))

CHAT_TEMPLATE = (
    "{% for message in messages %}"
    "{{ '<|' + message['role'] + '|>' + message['content'] + '<|end|>' }}"
    "{% endfor %}{% if add_generation_prompt %}{{ '<|assistant|>' }}{% endif %}"
)
"""Goes into the GGUF file. `render_prompt` is the same without a template engine."""


def render_prompt(messages: Iterable[Turn]) -> str:
    """Return the text that the model continues with its answer."""
    turns = "".join(f"<|{turn.role}|>{turn.content}{END}" for turn in messages)
    return turns + "<|assistant|>"


def train_tokenizer(examples: Iterable[Example], vocabulary_size: int) -> Tokenizer:
    """Train a BPE on the prompts and answers of a corpus."""
    tokenizer = _with_split(models.BPE())
    trainer = trainers.BpeTrainer(
        vocab_size=vocabulary_size,
        special_tokens=list(SPECIAL_TOKENS),
        # Every byte is a token, so that no text is unknown.
        initial_alphabet=pre_tokenizers.ByteLevel.alphabet(),
        show_progress=False,
    )
    tokenizer.train_from_iterator(_texts(examples), trainer)
    return tokenizer


def known_tokenizer(tokens: Sequence[str], merges: Sequence[str]) -> Tokenizer:
    """Return the tokenizer that has these tokens, by number, and merges (`left right`), in order.

    Raises:
        ConfigError: it is not one of `train_tokenizer`.
    """
    missing = sorted({*SPECIAL_TOKENS, *pre_tokenizers.ByteLevel.alphabet()} - set(tokens))
    if missing:
        raise ConfigError(
            f"the tokenizer lacks {len(missing)} tokens that training needs, such as "
            f"'{missing[0]}': it was not made by `w2c train language`"
        )
    pairs = [(left, right) for left, _, right in (merge.partition(" ") for merge in merges)]
    vocabulary = {token: number for number, token in enumerate(tokens)}
    tokenizer = _with_split(models.BPE(vocab=vocabulary, merges=pairs))
    tokenizer.add_special_tokens(list(SPECIAL_TOKENS))
    return tokenizer


def _with_split(model: models.BPE) -> Tokenizer:
    tokenizer = Tokenizer(model)
    tokenizer.pre_tokenizer = pre_tokenizers.Sequence(
        [
            pre_tokenizers.Split(Regex(SPLIT), behavior="isolated"),
            pre_tokenizers.ByteLevel(add_prefix_space=False, use_regex=False),
        ]
    )
    tokenizer.decoder = decoders.ByteLevel()
    return tokenizer


def _texts(examples: Iterable[Example]) -> Iterable[str]:
    for example in examples:
        for turn in example.messages:
            yield turn.content
        yield example.answer


@dataclass(frozen=True)
class EncodedExample:
    """Tokens of one example: prompt, answer, end of turn."""

    tokens: npt.NDArray[np.uint16]
    prompt_length: int
    """How many of them the model is given"""
    task: str


def encode(tokenizer: Tokenizer, example: Example) -> EncodedExample:
    """Return the tokens of an example."""
    return next(encode_all(tokenizer, [example]))


def encode_all(tokenizer: Tokenizer, examples: Iterable[Example]) -> Iterator[EncodedExample]:
    """Yield the tokens of examples.

    Prompt and answer are encoded apart: the answer begins after a special token, where no merge
    reaches over.
    """
    rest = iter(examples)
    end = tokenizer.token_to_id(END)
    while block := list(islice(rest, _BLOCK)):
        prompts = tokenizer.encode_batch_fast(
            [render_prompt(example.messages) for example in block], add_special_tokens=False
        )
        answers = tokenizer.encode_batch_fast(
            [example.answer for example in block], add_special_tokens=False
        )
        for example, prompt, answer in zip(block, prompts, answers, strict=True):
            tokens = np.array([*prompt.ids, *answer.ids, end], np.uint16)
            yield EncodedExample(tokens, len(prompt.ids), example.task)
