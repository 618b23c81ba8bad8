"""The byte-level BPE of the embedded model, and how a chat becomes tokens.

The split before BPE is the one that llama.cpp calls `qwen2`; it keeps digits single, which makes
numbers easy to copy. What is trained here must be tokenised identically there: a test compares the
two.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from tokenizers import Regex, Tokenizer, decoders, models, pre_tokenizers, trainers

from w2c_llm.train.corpus import Example, Turn

PRE_TOKENIZER = "qwen2"
SPLIT = (
    r"(?i:'s|'t|'re|'ve|'m|'ll|'d)|[^\r\n\p{L}\p{N}]?\p{L}+|\p{N}| ?[^\s\p{L}\p{N}]+[\r\n]*"
    r"|\s*[\r\n]+|\s+(?!\S)|\s+"
)

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
    tokenizer = Tokenizer(models.BPE())
    tokenizer.pre_tokenizer = pre_tokenizers.Sequence(
        [
            pre_tokenizers.Split(Regex(SPLIT), behavior="isolated"),
            pre_tokenizers.ByteLevel(add_prefix_space=False, use_regex=False),
        ]
    )
    tokenizer.decoder = decoders.ByteLevel()
    trainer = trainers.BpeTrainer(
        vocab_size=vocabulary_size,
        special_tokens=list(SPECIAL_TOKENS),
        # Every byte is a token, so that no text is unknown.
        initial_alphabet=pre_tokenizers.ByteLevel.alphabet(),
        show_progress=False,
    )
    tokenizer.train_from_iterator(_texts(examples), trainer)
    return tokenizer


def _texts(examples: Iterable[Example]) -> Iterable[str]:
    for example in examples:
        for turn in example.messages:
            yield turn.content
        yield example.answer


@dataclass(frozen=True)
class EncodedExample:
    """Tokens of one example: prompt, answer, end of turn."""

    tokens: list[int]
    prompt_length: int
    """How many of them the model is given"""
    task: str


def encode(tokenizer: Tokenizer, example: Example) -> EncodedExample:
    """Return the tokens of an example.

    Prompt and answer are encoded apart: the answer begins after a special token, where no merge
    reaches over.
    """
    prompt = tokenizer.encode(render_prompt(example.messages), add_special_tokens=False).ids
    answer = tokenizer.encode(example.answer, add_special_tokens=False).ids
    end = tokenizer.encode(END, add_special_tokens=False).ids
    return EncodedExample([*prompt, *answer, *end], len(prompt), example.task)
