"""One operator and one picture: prompts, until the dot is in the ring or five were said."""

from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from w2c.errors import ConfigError
from w2c.messages import Turn
from w2c_evaluation.corrections.eye import Look, Pixel, distance
from w2c_evaluation.corrections.operator import Operator, Seen
from w2c_evaluation.corrections.pictures import Picture, read_picture
from w2c_evaluation.corrections.saying import Saying
from w2c_evaluation.corrections.services import Boxes, Conversation, Stage, open_stage
from w2c_evaluation.corrections.voice import read_voice

MOST_PROMPTS = 5
PHASES = (1, 2)


class Prompt(msgspec.Struct, frozen=True, kw_only=True):
    """What was said once, and what came of it."""

    text: str
    kind: str
    """Of phrasing; `answer` and `cancel` follow questions"""
    module: str
    """Of the dialogue, that answered"""
    ok: bool
    reply: str
    asks: bool
    """The reply is a question"""
    point: Pixel | None
    """Of the dot, afterwards"""
    distance: float | None
    """From the ring's centre, afterwards [px]; None: there is no dot"""
    wanted: Pixel | None = None
    """Where who spoke expected the dot"""


class Trial(msgspec.Struct, frozen=True, kw_only=True):
    """Everything that was said about one picture."""

    picture: int
    """Seed of its scene"""
    ring: Pixel
    pixels_per_cm: float
    prompts: tuple[Prompt, ...]

    def distance_after(self, count: int) -> float | None:
        """Return the distance after so many prompts [px]; None: there was no dot.

        Who stopped earlier left the dot where it was.
        """
        said = self.prompts[:count]
        return said[-1].distance if said else None


class Session(msgspec.Struct, frozen=True, kw_only=True):
    """One operator in one phase of the study."""

    voice: str
    operator: int
    phase: int
    trials: tuple[Trial, ...]


@dataclass(frozen=True)
class Study:
    """What all sessions share. Picklable."""

    pictures: Path
    first_picture: int
    picture_count: int
    images: int
    """A session"""
    boxes: Boxes
    model: str
    seed: int


def run_session(study: Study, voice: str, operator: int, phase: int) -> Session:
    """Play one operator's phase, in a process of its own.

    Raises:
        W2CError: a model cannot be loaded, or a picture cannot be read.
    """
    rng = np.random.default_rng([study.seed, *voice.encode(), operator, phase])
    person = Operator(read_voice(voice), rng, corrects=phase == 2)
    with open_stage(model=study.model, boxes=study.boxes, seed=study.seed) as stage:
        trials = tuple(
            run_trial(stage, person, picture, ring)
            for picture, ring in draw_tasks(study, voice, operator, phase)
        )
    return Session(voice=voice, operator=operator, phase=phase, trials=trials)


def draw_tasks(study: Study, voice: str, operator: int, phase: int) -> list[tuple[Picture, Pixel]]:
    """Return the pictures of a session, each with the centre of its ring.

    Both phases of an operator are drawn together: no picture comes twice.

    Raises:
        ConfigError: too few of the pictures show anything to point at, or one cannot be read.
    """
    rng = np.random.default_rng([study.seed, *voice.encode(), operator])
    tasks: list[tuple[Picture, Pixel]] = []
    for index in rng.permutation(study.picture_count):
        picture = read_picture(study.pictures, study.first_picture + int(index))
        ring = picture.draw_ring(rng) if picture.things else None
        if ring is not None:
            tasks.append((picture, ring))
        if len(tasks) == study.images * len(PHASES):
            break
    if len(tasks) < study.images * len(PHASES):
        raise ConfigError(
            f"{len(tasks)} of {study.picture_count} pictures show something to point at, an "
            f"operator needs {study.images * len(PHASES)}: use more --pictures"
        )
    first = (phase - 1) * study.images
    return tasks[first : first + study.images]


def run_trial(stage: Stage, person: Operator, picture: Picture, ring: Pixel) -> Trial:
    """Return what one operator said about one picture."""
    person.begin()
    scale = picture.pixels_per_cm(ring)
    talk = _Talk(stage.begin(picture), ring)
    asked: tuple[Turn, Saying] | None = None
    while len(talk.prompts) < MOST_PROMPTS:
        look = Look(talk.dot, ring, picture.things, scale)
        if asked is not None:
            turn, about = asked
            answer, before = person.answer(turn, about), talk.dot
            words = answer or person.drop(look)
            asked = None
            if words is not None:
                turn = talk.say(words, "answer" if answer else "cancel", about.lands)
                if answer:
                    person.hear(about, before, _seen(turn, talk))
                    asked = (turn, about) if turn.options else None
                continue
            person.hear(about, before, _seen(turn, talk))
        saying = person.speak(look)
        if saying is None:
            break
        before = talk.dot
        turn = talk.say(saying.text, saying.kind, saying.lands)
        if turn.options:
            asked = (turn, saying)
        else:
            person.hear(saying, before, _seen(turn, talk))
    return Trial(picture=picture.seed, ring=ring, pixels_per_cm=scale, prompts=tuple(talk.prompts))


class _Talk:
    """A conversation, written down."""

    def __init__(self, conversation: Conversation, ring: Pixel) -> None:
        self._conversation = conversation
        self._ring = ring
        self._target_id = ""
        self.dot: Pixel | None = None
        self.prompts: list[Prompt] = []

    def say(self, text: str, kind: str, wanted: Pixel) -> Turn:
        """Say words; follow the dot."""
        turn = self._conversation.say(text, self._target_id)
        target = turn.target
        if target is not None:
            shown = target.state == "proposed"
            self.dot = (target.u, target.v) if shown else None
            self._target_id = target.target_id if shown else ""
        self.prompts.append(
            Prompt(
                text=text,
                kind=kind,
                module=turn.module,
                ok=turn.ok,
                reply=turn.reply,
                asks=bool(turn.options),
                point=self.dot,
                distance=None if self.dot is None else distance(self.dot, self._ring),
                wanted=wanted,
            )
        )
        return turn


def _seen(turn: Turn, talk: _Talk) -> Seen:
    return Seen(turn.reply, turn.ok, talk.dot)
