"""A tokenizer of CLIP's format, made from the words of the training phrases.

CLIP's tokenizer is a byte-pair encoding with `</w>` at the end of a word. With merges learned
from a few hundred words every one of them becomes one token; any other word still has a spelling
in pieces.
"""

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

START, END = "<|startoftext|>", "<|endoftext|>"
WORD_END = "</w>"

Pair = tuple[str, str]


def learn_merges(words: Sequence[str]) -> list[Pair]:
    """Return the merges, most frequent pair first, after which each word is one symbol.

    Sennrich et al., "Neural Machine Translation of Rare Words with Subword Units", ACL 2016,
    algorithm 1, run until nothing is left to merge. Ties go to the alphabetically first pair: the
    result depends on the set of words only.
    """
    spellings = [[*word[:-1], word[-1] + WORD_END] for word in sorted(set(words))]
    merges: list[Pair] = []
    while True:
        counts = Counter(pair for spelling in spellings for pair in pairwise(spelling))
        if not counts:
            return merges
        best = min(counts, key=lambda pair: (-counts[pair], pair))
        merges.append(best)
        spellings = [_merged(spelling, best) for spelling in spellings]


def _merged(spelling: list[str], pair: Pair) -> list[str]:
    result: list[str] = []
    index = 0
    while index < len(spelling):
        if tuple(spelling[index : index + 2]) == pair:
            result.append(pair[0] + pair[1])
            index += 2
        else:
            result.append(spelling[index])
            index += 1
    return result


def make_vocabulary(merges: Sequence[Pair]) -> dict[str, int]:
    """Return token -> id. Every byte is there, so that any text has tokens.

    The end token has the last id: old configurations find the end of a phrase by the largest id.
    """
    from tokenizers.pre_tokenizers import ByteLevel

    alphabet = sorted(ByteLevel.alphabet())
    tokens = [*alphabet, *(character + WORD_END for character in alphabet)]
    tokens += [first + second for first, second in merges]
    tokens = list(dict.fromkeys(tokens))
    return {token: index for index, token in enumerate([*tokens, START, END])}


def make_tokenizer(words: Sequence[str], longest: int) -> Any:
    """Return a `CLIPTokenizer` whose phrases are at most `longest` tokens."""
    from transformers import CLIPTokenizer

    merges = learn_merges(words)
    # Any: the class annotates `merges` as names of files only, and takes pairs.
    make: Any = CLIPTokenizer
    return make(
        vocab=make_vocabulary(merges),
        merges=merges,
        bos_token=START,
        eos_token=END,
        unk_token=END,
        pad_token=END,
        model_max_length=longest,
    )
