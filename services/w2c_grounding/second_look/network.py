"""The network of the second look: a square of the picture and a phrase in, a logit out."""

from collections.abc import Sequence

import torch
from torch import nn
from torch.nn import functional

from w2c_grounding.wording import words

WIDTH = 192
"""Of what is known of a square, and of a phrase"""
_CHANNELS = (24, 32, 64, 96, 160)
_WORD = 96
ARTICLES = frozenset({"a", "an", "the", "this", "that", "my", "your"})
"""Words before a noun that say nothing of what it looks like"""


class Residual(nn.Module):
    """Two convolutions around which their input goes as well (He et al., CVPR 2016, figure 2)."""

    def __init__(self, channels_in: int, channels: int, stride: int) -> None:
        super().__init__()
        self.first = nn.Conv2d(channels_in, channels, 3, stride, 1, bias=False)
        self.first_norm = nn.BatchNorm2d(channels)
        self.second = nn.Conv2d(channels, channels, 3, 1, 1, bias=False)
        self.second_norm = nn.BatchNorm2d(channels)
        self.past = nn.Conv2d(channels_in, channels, 1, stride, bias=False)
        self.past_norm = nn.BatchNorm2d(channels)

    def forward(self, maps: torch.Tensor) -> torch.Tensor:
        """Return (n, channels, h / stride, w / stride)."""
        inner = functional.relu(self.first_norm(self.first(maps)))
        return functional.relu(
            self.second_norm(self.second(inner)) + self.past_norm(self.past(maps))
        )


class SecondLookNetwork(nn.Module):
    """Reads squares and phrases apart from each other, and matches them."""

    def __init__(self, vocabulary: Sequence[str]) -> None:
        """Make a network with random weights.

        Args:
            vocabulary: The words that it knows; all others are one to it.
        """
        super().__init__()
        self.vocabulary = list(vocabulary)
        self.numbers = {word: number for number, word in enumerate(vocabulary, start=1)}
        stem, *others = _CHANNELS
        layers: list[nn.Module] = [
            nn.Conv2d(3, stem, 5, 2, 2, bias=False),
            nn.BatchNorm2d(stem),
            nn.ReLU(),
        ]
        for number, (before, channels) in enumerate(zip(_CHANNELS[:-1], others, strict=True)):
            layers.append(Residual(before, channels, 1 if number == 0 else 2))
        self.maps = nn.Sequential(*layers)
        self.summary = nn.Linear(2 * _CHANNELS[-1], WIDTH)
        self.words = nn.Embedding(len(vocabulary) + 1, _WORD)
        self.sentence = nn.GRU(_WORD, WIDTH, batch_first=True)
        self.meaning = nn.Linear(WIDTH, WIDTH)
        self.agreement = nn.Sequential(nn.Linear(WIDTH, 64), nn.ReLU(), nn.Linear(64, 1))

    def see(self, squares: torch.Tensor) -> torch.Tensor:
        """Return what is seen (n, WIDTH) in squares (n, 3, side, side), 0 to 1."""
        maps = self.maps((squares - 0.5) / 0.25)
        pooled = torch.cat([maps.mean(dim=(2, 3)), maps.amax(dim=(2, 3))], dim=1)
        seen: torch.Tensor = self.summary(pooled)
        return seen

    def read(self, tokens: torch.Tensor, lengths: torch.Tensor) -> torch.Tensor:
        """Return what phrases mean (m, WIDTH): tokens (m, longest), lengths (m,) of at least 1."""
        states, _ = self.sentence(self.words(tokens))
        last = states[torch.arange(len(tokens), device=tokens.device), lengths - 1]
        meant: torch.Tensor = self.meaning(last)
        return meant

    def match(self, seen: torch.Tensor, meant: torch.Tensor) -> torch.Tensor:
        """Return the logits (...) that squares (..., WIDTH) show what is meant (..., WIDTH)."""
        product = seen * meant
        learned: torch.Tensor = self.agreement(product).squeeze(-1)
        return product.mean(dim=-1) + learned

    def tokens(self, phrases: Sequence[str]) -> tuple[torch.Tensor, torch.Tensor]:
        """Return the tokens and lengths of phrases, for `read`; 0 is a word that is not known."""
        numbers = [
            [self.numbers.get(word, 0) for word in said(phrase)] or [0] for phrase in phrases
        ]
        longest = max(len(one) for one in numbers)
        padded = torch.tensor([one + [0] * (longest - len(one)) for one in numbers])
        return padded, torch.tensor([len(one) for one in numbers])


def with_words(network: SecondLookNetwork, vocabulary: Sequence[str]) -> SecondLookNetwork:
    """Return a network that knows these words as well; all else means what it did."""
    new = sorted(set(vocabulary) - set(network.vocabulary))
    grown = SecondLookNetwork([*network.vocabulary, *new])
    values = network.state_dict()
    fresh = grown.words.weight.detach()
    values["words.weight"] = torch.cat([values["words.weight"], fresh[len(fresh) - len(new) :]])
    grown.load_state_dict(values)
    return grown


def said(phrase: str) -> list[str]:
    """Return the words of a phrase, without those that only introduce it."""
    return [word for word in words(phrase) if word not in ARTICLES]
