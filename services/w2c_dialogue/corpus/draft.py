"""An utterance in the making: words, and which of them name an object."""

from dataclasses import dataclass, field

from w2c_dialogue.utterance import LETTERS, Span, Utterance, fold, parse


@dataclass
class Draft:
    """Words with the letter of the object they belong to; an empty letter for all other words."""

    words: list[str] = field(default_factory=list)
    letters: list[str] = field(default_factory=list)

    def add(self, text: str, letter: str = "") -> None:
        """Append the words of a text."""
        words = text.split()
        self.words += words
        self.letters += [letter] * len(words)

    def prepend(self, text: str) -> None:
        """Put the words of a text in front."""
        words = text.split()
        self.words[:0] = words
        self.letters[:0] = [""] * len(words)

    def fill(self, template: str, phrases: dict[str, str]) -> None:
        """Append a template whose words `{A}`, `{B}`, `{C}` are replaced by phrases."""
        for word in template.split():
            at = word.find("{")
            if at < 0:
                self.add(word)
                continue
            letter = word[at + 1]
            self.add(phrases[letter], letter.lower())
            self.words[-1] += word[at + 3 :]
            self.words[-len(phrases[letter].split())] = (
                word[:at] + self.words[-len(phrases[letter].split())]
            )

    def finish(self) -> tuple[Utterance, list[Span]]:
        """Return the utterance and the span of the first mention of each object, in order."""
        utterance = parse(" ".join(self.words))
        # Punctuation that stands alone is no word of an utterance.
        pairs = zip(self.words, self.letters, strict=True)
        letters = [letter for word, letter in pairs if fold(word).strip(",")]
        spans = []
        for letter in LETTERS:
            if letter in letters:
                first = last = letters.index(letter)
                while last + 1 < len(letters) and letters[last + 1] == letter:
                    last += 1
                spans.append(Span(first + 1, last + 1))
        return utterance, spans
