"""A batch's questions, answered by the modules that the robot's dialogue runs."""

from collections.abc import Callable, Sequence

from w2c.errors import ModelError, RefusedError
from w2c_dialogue.analyzer import analyze, objects_of_correction
from w2c_dialogue.batch.lines import (
    Analyze,
    Answer,
    Correct,
    Dialogue,
    Effector,
    Question,
    Relative,
    Select,
    Thing,
)
from w2c_dialogue.corrector import corrected_point
from w2c_dialogue.effector import choose_effector
from w2c_dialogue.expressions import clip
from w2c_dialogue.interfaces import LanguageModel
from w2c_dialogue.prompts.base import CorrectionScene, Move, PromptSet, SceneObject
from w2c_dialogue.relative import described
from w2c_dialogue.selector import Selection, select
from w2c_dialogue.utterance import LETTERS, Mention, Span, Utterance, fold, parse

SIZE = (1280, 720)
"""Of the pictures that a batch speaks of [px]"""
Named = tuple[tuple[Mention, ...], tuple[SceneObject, ...]]
"""Words of an utterance, and the things that they mean"""
_ARTICLES = frozenset({"a", "an", "the"})


class Answering:
    """One language model and one prompt set."""

    def __init__(self, model: LanguageModel, prompts: PromptSet) -> None:
        self._model = model
        self._prompts = prompts

    def answer(self, question: Question) -> Answer:
        """Return the fields of the answer beside the id.

        Raises:
            W2CError: the text is refused, or the model did not give a usable answer.
        """
        match question:
            case Select():
                return self._select(question.text)
            case Analyze():
                utterance = parse(question.text)
                analysis = analyze(self._model, self._prompts, utterance)
                objects = [
                    mention.phrase if mention.span is None else utterance.verbatim(mention.span)
                    for mention in analysis.mentions
                ]
                return {"position": analysis.position, "objects": objects}
            case Effector():
                limb, task = choose_effector(self._model, self._prompts, parse(question.text))
                return {"end_effector": limb or "unspecified", "task_type": task}
            case Relative():
                return self._relative(question)
            case Correct():
                return self._correct(question)
            case Dialogue():
                return {"modules": self._dialogue(question.turns)}

    def _select(self, text: str) -> Answer:
        choice = self._choose(text, has_target=True)
        return {"module": choice.module, "probabilities": choice.probabilities}

    def _choose(self, text: str, *, has_target: bool) -> Selection:
        return select(self._model, self._prompts, parse(text), has_target=has_target)

    def _dialogue(self, turns: Sequence[str]) -> list[str]:
        """Return the module of each turn; the first target appears with the first instruction."""
        modules: list[str] = []
        for number, text in enumerate(turns, 1):
            try:
                modules.append(self._choose(text, has_target=bool(modules)).module)
            except RefusedError as error:
                raise RefusedError(f"turn {number}: {error}") from error
        return modules

    def _relative(self, question: Relative) -> Answer:
        utterance = parse(question.text)
        mentions, objects = self._things(
            utterance,
            question.objects,
            lambda: analyze(self._model, self._prompts, utterance).mentions,
        )
        if not objects:
            # "left of it": the words name nothing, and the line says what they mean.
            objects = tuple(map(_seen, question.objects[: len(LETTERS)]))
            mentions = tuple(Mention(item.phrase, None) for item in objects)
        place = described(
            self._model,
            self._prompts,
            utterance=utterance,
            mentions=mentions,
            objects=objects,
            pixels_per_cm=question.px_per_cm,
        )
        point = clip(place.u, place.v, SIZE)
        return {"point": [point.u, point.v], "clipped": point.clipped}

    def _correct(self, question: Correct) -> Answer:
        utterance = parse(question.text)
        mentions, objects = self._things(
            utterance,
            question.objects,
            lambda: objects_of_correction(self._model, self._prompts, utterance),
        )
        moves = tuple(Move(du, dv) for du, dv in question.previous_moves)
        start = (
            question.target[0] - sum(move.du for move in moves),
            question.target[1] - sum(move.dv for move in moves),
        )
        scene = CorrectionScene(
            question.target, start, moves, ("",) * len(moves), objects, question.px_per_cm
        )
        point, _ = corrected_point(self._model, self._prompts, utterance, mentions, scene, SIZE)
        return {"point": [point.u, point.v], "clipped": point.clipped}

    @staticmethod
    def _things(
        utterance: Utterance, things: Sequence[Thing], ask: Callable[[], Sequence[Mention]]
    ) -> Named:
        """Return the things that an utterance speaks of; `ask` where not all words are in it."""
        named = name_things(utterance, things)
        return pair_things(ask(), things) if named is None else named


def name_things(utterance: Utterance, things: Sequence[Thing]) -> Named | None:
    """Return things with their words in an utterance, in order of mention.

    None where the words of one are not in it: then a model has to say which words mean it.
    """
    found: list[tuple[Span, Thing]] = []
    for thing in things:
        span = find_words(utterance, thing.phrase, [span for span, _ in found])
        if span is None:
            return None
        found.append((span, thing))
    found.sort(key=lambda entry: entry[0][0])
    mentions = tuple(Mention(utterance.phrase(span), span) for span, _ in found)
    return mentions, tuple(_seen(thing) for _, thing in found)


def find_words(utterance: Utterance, phrase: str, taken: Sequence[Span]) -> Span | None:
    """Return the first words of an utterance that are a phrase and are not taken, or None.

    An article at the beginning of the phrase is no part of a name.
    """
    wanted = _words(phrase)
    words = [_bare(word) for word in utterance.folded]
    for first in range(len(words) - len(wanted) + 1):
        last = first + len(wanted)
        free = all(last <= span[0] - 1 or first >= span[1] for span in taken)
        if wanted and free and words[first:last] == wanted:
            return Span(first + 1, last)
    return None


def pair_things(mentions: Sequence[Mention], things: Sequence[Thing]) -> Named:
    """Return the mentions that a model found with the things, in order of mention.

    Those that share most words belong together; the rest follows the order of both. What was
    mentioned beside things of the line, such as the table that they stand on, is left out.

    Raises:
        ModelError: there are more mentions than things, and no thing by its own words.
    """
    alike = [
        (-_likeness(mention.phrase, thing.phrase), m, t)
        for m, mention in enumerate(mentions)
        for t, thing in enumerate(things)
    ]
    pairs: dict[int, int] = {}
    for likeness, m, t in sorted(alike):
        if likeness < 0 and m not in pairs and t not in pairs.values():
            pairs[m] = t
    if len(mentions) > len(things) and not pairs:
        phrases = ", ".join(f"'{mention.phrase}'" for mention in mentions)
        raise ModelError(f"{phrases} were heard, and the line gives {len(things)} objects")
    left = [t for t in range(len(things)) if t not in pairs.values()]
    for m in range(len(mentions)):
        if m not in pairs and left:
            pairs[m] = left.pop(0)
    order = sorted(pairs)
    return tuple(mentions[m] for m in order), tuple(_seen(things[pairs[m]]) for m in order)


def _seen(thing: Thing) -> SceneObject:
    return SceneObject(thing.phrase, thing.box)


def _likeness(one: str, other: str) -> float:
    """Return the share of the words of two names that they have in common, 0 to 1."""
    mine, theirs = set(_words(one)), set(_words(other))
    return len(mine & theirs) / max(len(mine | theirs), 1)


def _words(phrase: str) -> list[str]:
    words = [_bare(word) for word in phrase.split() if _bare(word)]
    return words[1:] if len(words) > 1 and words[0] in _ARTICLES else words


def _bare(word: str) -> str:
    return fold(word).rstrip(",").removesuffix("'s")
