"""Plays a scenario as a person would: speaks, looks at the point, corrects, confirms, watches.

What is said comes from the scripted operator, who sees the picture; what is written down beside it
comes from the truth about that picture. Pictures are taken when the operator looks, before each
prompt: the robot stands still from then until a target is confirmed.
"""

import time

import numpy as np

from w2c import topics
from w2c.bus import Bus
from w2c.errors import CallError
from w2c.messages import (
    CameraFrame,
    CaptureRequest,
    ConfirmRequest,
    GoalEvent,
    PictureRequest,
    SayRequest,
    Target,
    Turn,
)
from w2c_evaluation.demo.operator import FINAL_STATES, ScenarioError
from w2c_evaluation.scenarios.answering import MOST_QUESTIONS, read_question
from w2c_evaluation.scenarios.eyewitness import Wanted, circle_of, find_place
from w2c_evaluation.scenarios.film import Film
from w2c_evaluation.scenarios.noting import Said, note
from w2c_evaluation.scenarios.phrase_book import PhraseBook
from w2c_evaluation.scenarios.record import Asks, Kind, Motion, Played, PromptRun
from w2c_evaluation.scenarios.scenario import Prompt, Scenario
from w2c_evaluation.scenarios.scripted_words import ScriptedWords
from w2c_evaluation.scenarios.sight import Sight
from w2c_evaluation.scenarios.speaker import GiveUp, Speaker, Yes
from w2c_evaluation.scenarios.truth_log import TruthLog
from w2c_evaluation.scenarios.wording import Saying

STAND_PATIENCE_S = 180.0
PLACED_PATIENCE_S = 8.0
MOST_PICTURES = 4
"""In a row, of which some are lost"""
LOOK_AGAIN = "Look at the live picture"
"""How the dialogue asks for it, where it does not have a picture"""
KINDS: dict[type[Prompt | Saying | Yes], Kind] = {
    Prompt: "prompt",
    Saying: "correction",
    Yes: "yes",
}
MOTION_PATIENCE_S = 300.0
"""Wall time: a lock step on a busy machine takes five times as long as the motion"""
SETTLE_S = {"contact": 1.5, "reach": 3.0}
"""Robot time that is watched after the end was reported [s]"""


class Conversation:
    """One run with one system."""

    def __init__(
        self,
        bus: Bus,
        log: TruthLog,
        book: PhraseBook,
        film: Film,
        *,
        rng: np.random.Generator,
        words: ScriptedWords | None = None,
    ) -> None:
        """Begin to listen.

        Args:
            bus: Of an operator.
            log: Of what is true.
            book: Which objects phrases mean.
            film: Takes the pictures.
            rng: Draws places and the operator's words.
            words: Stand-in to be told what is said; None = the embedded model listens.
        """
        self._bus = bus
        self._log = log
        self._book = book
        self._film = film
        self._rng = rng
        self._words = words
        self._events = bus.queue(topics.GOAL_EVENT)
        self._status = bus.latest(topics.CONTROLLER_STATUS)
        self._views = bus.latest(topics.CAMERA_VIEW)
        self._frame: CameraFrame | None = None
        self.played = Played()

    def play(self, scenario: Scenario) -> None:
        """Play it as far as it goes. Raises ScenarioError where the system does not answer."""
        self._wait_until_it_stands()
        for prompt in scenario.prompts:
            run = PromptRun()
            self.played.prompts.append(run)
            self._perform(prompt, run)
            if not _ended_well(prompt, run):
                return

    def succeeded(self, scenario: Scenario) -> bool:
        """Return whether every prompt was played to its end."""
        runs = self.played.prompts
        return len(runs) == len(scenario.prompts) and _ended_well(scenario.prompts[-1], runs[-1])

    def show(self, caption: str) -> None:
        """Keep a picture of the robot from outside."""
        self._film.take(self._outside(), caption)

    def _wait_until_it_stands(self) -> None:
        deadline = time.monotonic() + STAND_PATIENCE_S
        while time.monotonic() < deadline:
            status = self._status.wait(0.5)
            standing = status is not None and status.message.phase == "hold"
            if standing and self._log.newest_ns >= 0:
                return
        raise ScenarioError("the robot does not stand")

    def _perform(self, prompt: Prompt, run: PromptRun) -> None:
        """Say a prompt, bring its point to the place, confirm it, and watch what comes of it."""
        place = prompt.place.drawn(self._rng)
        frame = self._look_anew()
        with self._log.moment(frame.stamp_ns) as witness:
            run.wanted = find_place(witness, place)
        if run.wanted is None:
            run.problem = f"the place ({place.description}) is hidden"
            return
        beside_cm = 100.0 * float(np.linalg.norm(place.beside))
        speaker = Speaker(self._rng, beside_cm=beside_cm)
        target = self._say(prompt, run, None, speaker)
        if target is None and run.turns[-1].asks == "open":
            again = speaker.repeat(prompt)
            if again is not None:
                target = self._say(again, run, None, speaker)
        while target is not None:
            sight = self._look(target, run.wanted)
            jpeg = frame.jpeg if self._frame is None else self._frame.jpeg
            self._film.show(jpeg, target, sight.wanted, run.turns[-1].text)
            answer = speaker.answer(sight)
            if isinstance(answer, GiveUp):
                run.problem = answer.reason
                return
            shown = self._say(answer, run, target, speaker)
            if isinstance(answer, Yes):
                if run.motion is None and (shown is None or shown.target_id == target.target_id):
                    self._press_confirm(target, run)
                if run.motion is not None or run.problem:
                    break
            target = shown if shown is not None else target
        if run.motion is None:
            run.problem = run.problem or f"no target: {run.turns[-1].reply}"
            return
        self._follow(run.motion)
        limb = run.motion.effector.replace("_", " ")
        self.show(f"{limb}: {run.motion.state}")

    def _say(
        self,
        said: Prompt | Saying | Yes,
        run: PromptRun,
        target: Target | None,
        speaker: Speaker,
    ) -> Target | None:
        """Say something, and answer what is asked back.

        Returns:
            The target that is shown then; None where none is proposed.
        """
        if self._words is not None:
            self._words.expect(said)
        meant = (said.du, said.dv) if isinstance(said, Saying) else None
        about = Said(KINDS[type(said)], target, meant)
        turn, answered = self._tell(said.text, target), 0
        while answered < MOST_QUESTIONS:
            answer = self._answer(turn, said, run, speaker)
            if answer is None:
                break
            self._note(turn, about, run, "answered", answers=answered > 0)
            turn, answered = self._tell(answer, target), answered + 1
        self._note(turn, about, run, "open" if turn.options else "", answers=answered > 0)
        return turn.target

    def _answer(
        self, turn: Turn, said: Prompt | Saying | Yes, run: PromptRun, speaker: Speaker
    ) -> str | None:
        """Return the answer to what a turn asks; None: it asks nothing, or no option fits."""
        question = read_question(turn)
        if question is None or run.wanted is None or self._frame is None:
            return None
        with self._log.moment(self._frame.stamp_ns) as witness:
            wanted = circle_of(witness, run.wanted)
        return speaker.answer_question(question, said, wanted)

    def _tell(self, text: str, target: Target | None) -> Turn:
        """Say words; returns the answer."""
        for _ in range(MOST_PICTURES):
            # Who corrects or confirms looks at the picture that the target is shown in.
            request = SayRequest(
                text=text,
                frame_stamp_ns=-1 if self._frame is None else self._frame.stamp_ns,
                target_id="" if target is None else target.target_id,
            )
            turn = self._bus.call(topics.SAY, request).message
            if turn.ok or LOOK_AGAIN not in turn.reply:
                break
            self._look_anew()
        return turn

    def _press_confirm(self, target: Target, run: PromptRun) -> None:
        """Press the button of the page, as who is not understood does."""
        last = run.turns[-1]
        if last.module == "confirmation":  # it was understood, and refused
            run.problem = f"not gone to: {last.reply}"
            return
        request = ConfirmRequest(target_id=target.target_id)
        turn = self._bus.call(topics.CONFIRM, request).message
        self._note(turn, Said("button", target), run)
        if run.motion is None:
            run.problem = f"not gone to: {turn.reply}"

    def _note(
        self, turn: Turn, said: Said, run: PromptRun, asks: Asks = "", *, answers: bool = False
    ) -> None:
        """Write a turn down, and the motion that it started."""
        run.turns.append(note(turn, said, self._log, self._book, asks, answers=answers))
        if turn.goal_id:
            run.motion = Motion(
                turn.goal_id,
                turn.end_effector,  # type: ignore[arg-type]
                turn.task,  # type: ignore[arg-type]
                confirmed_ns=self._log.newest_ns,
            )

    def _look(self, target: Target, wanted: Wanted) -> Sight:
        """Return what the operator sees of the target and of the place in the target's picture."""
        with self._log.moment(target.frame_stamp_ns) as witness:
            return Sight((target.u, target.v), circle_of(witness, wanted))

    def _follow(self, motion: Motion) -> None:
        """Wait for the end of a motion, then until it has settled."""
        deadline = time.monotonic() + MOTION_PATIENCE_S
        while (remaining := deadline - time.monotonic()) > 0 and not motion.state:
            received = self._events.receive(min(remaining, 0.5))
            if received is not None:
                self._heed(received.message, motion)
        if not motion.state:
            motion.state = "unfinished"
            motion.reason = f"no end within {MOTION_PATIENCE_S:.0f} s"
            motion.ended_ns = motion.settled_ns = self._log.newest_ns
            return
        settled_ns = motion.ended_ns + round(SETTLE_S[motion.task] * 1e9)
        if not self._log.wait_for(settled_ns, MOTION_PATIENCE_S):
            raise ScenarioError("the simulator stopped telling the truth: is it still running?")
        motion.settled_ns = settled_ns
        while (received := self._events.receive(0.0)) is not None:
            self._heed(received.message, motion)

    def _heed(self, event: GoalEvent, motion: Motion) -> None:
        if event.goal_id not in self.played.goal_ids:
            self.played.goal_ids.append(event.goal_id)
        if event.goal_id == motion.goal_id and event.state in FINAL_STATES:
            # What ends a hold of a support later (lost, overloaded) ends the run as well.
            motion.state, motion.reason = event.state, event.reason
            if motion.ended_ns < 0:
                motion.ended_ns = event.stamp_ns

    def _look_anew(self) -> CameraFrame:
        """Take a picture, and return it when it is known where it was taken from.

        Another one is taken where nobody tells: pictures are dropped on a line that is full.
        """
        for _ in range(MOST_PICTURES):
            try:
                frame = self._bus.call(topics.CAPTURE, CaptureRequest()).message
            except CallError as error:
                raise ScenarioError(f"the camera gives no picture: {error}") from error
            self._frame = frame
            deadline = time.monotonic() + PLACED_PATIENCE_S
            while time.monotonic() < deadline:
                view = self._views.last()
                if view is not None and view.message.stamp_ns >= frame.stamp_ns:
                    return frame
                self._views.wait(0.2)
        raise ScenarioError("nobody tells where pictures were taken from: is perception running?")

    def _outside(self) -> bytes:
        """Return a picture of the robot from its side; b"" where none comes."""
        try:
            request = PictureRequest(view="side", width=960, height=540)
            return self._bus.call(topics.PICTURE, request).message.jpeg
        except CallError:
            return b""


def _ended_well(prompt: Prompt, run: PromptRun) -> bool:
    end = "loaded" if prompt.meaning.task == "contact" else "reached"
    return run.motion is not None and run.motion.state == end
