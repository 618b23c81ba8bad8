"""Which object words mean, known for certain: for a stand-in that answers from truth."""

from collections.abc import Iterable, Mapping

ARTICLES = frozenset({"the", "a", "an", "this", "that", "your", "my"})


def normal(phrase: str) -> str:
    """Return a phrase in lower case, without articles, hyphens and punctuation."""
    kept = "".join(c if c.isalnum() else " " for c in phrase.lower().replace("'", ""))
    return " ".join(word for word in kept.split() if word not in ARTICLES)


class PhraseBook:
    """Phrases of a scene and of the prompts about it."""

    def __init__(
        self, of_objects: Mapping[str, Iterable[str]], of_prompts: Mapping[str, str]
    ) -> None:
        """Collect phrases.

        Args:
            of_objects: Name of an object -> phrases that fit it.
            of_prompts: Phrase -> name of the object that it means.
        """
        self._things: dict[str, list[str]] = {}
        for name, phrases in of_objects.items():
            for phrase in phrases:
                self._add(phrase, name)
        for phrase, name in of_prompts.items():
            self._things[normal(phrase)] = [name]

    def find(self, phrase: str) -> list[str]:
        """Return the objects that a phrase may mean; none = nobody would say so.

        A phrase that is not known as a whole means the objects of which one known phrase has all
        of its words: `wooden handle` for `thing with the wooden handle`.
        """
        wanted = normal(phrase)
        if wanted in self._things:
            return self._things[wanted]
        words = set(wanted.split())
        if not words:
            return []
        found: list[str] = []
        for known, names in self._things.items():
            if words <= set(known.split()):
                found += [name for name in names if name not in found]
        return found

    def _add(self, phrase: str, name: str) -> None:
        names = self._things.setdefault(normal(phrase), [])
        if name not in names:
            names.append(name)
