"""What a perfect language model would answer: a stand-in for the llm service.

It is told what is about to be said and what that means, and answers the questions of the prompt
set of the embedded model with it. With it, what still fails does not fail from words.
"""

import json
from typing import Any

from w2c import topics
from w2c.bus import Bus, CallContext
from w2c.errors import RefusedError
from w2c.messages import ChooseReply, ChooseRequest, CompleteReply, CompleteRequest
from w2c_evaluation.scenarios.scenario import Prompt
from w2c_evaluation.scenarios.speaker import Yes
from w2c_evaluation.scenarios.wording import Saying

NAME = "scripted"
BESIDE = {
    "left": ("a.left-0.2*a.width", "a.v"),
    "right": ("a.right+0.2*a.width", "a.v"),
    "behind": ("a.u", "a.top-0.2*a.height"),
    "front": ("a.u", "a.bottom+0.2*a.height"),
}
"""The point beside a thing that nobody said how far away"""


class ScriptedWords:
    """Answers `llm/choose` and `llm/complete`, on a bus that was opened as `llm`."""

    def __init__(self, bus: Bus) -> None:
        self._prompt: Prompt | None = None
        self._said: Prompt | Saying | Yes | None = None
        bus.serve(topics.CHOOSE, self.choose)
        bus.serve(topics.COMPLETE, self.complete)

    def expect(self, said: Prompt | Saying | Yes) -> None:
        """Learn what will be said next."""
        if isinstance(said, Prompt):
            self._prompt = said
        self._said = said

    def choose(self, request: ChooseRequest, _context: CallContext) -> ChooseReply:
        """Choose the module. Raises RefusedError where nothing was announced."""
        option = _module(self._said)
        if option not in request.options:
            raise RefusedError(f"no '{option}' among the options {request.options}")
        return ChooseReply(
            option=option,
            probabilities={name: float(name == option) for name in request.options},
            model=NAME,
            prompt_tokens=0,
            reused_tokens=0,
            queue_ms=0.0,
            prefill_ms=0.0,
        )

    def complete(self, request: CompleteRequest, _context: CallContext) -> CompleteReply:
        """Answer a question of the embedded prompt set. Raises RefusedError for another one."""
        tag, words = request.messages[0].content, request.messages[-1].content
        value = self._answer(tag, words)
        return CompleteReply(
            text=json.dumps(value),
            value=value,
            model=NAME,
            prompt_tokens=0,
            reused_tokens=0,
            completion_tokens=0,
            queue_ms=0.0,
            prefill_ms=0.0,
            decode_ms=0.0,
        )

    def _answer(self, tag: str, words: str) -> dict[str, Any]:
        said, prompt = self._said, self._prompt
        if prompt is None:
            raise RefusedError("nothing was announced that this could be about")
        meaning = prompt.meaning
        if tag == "effector":  # asked at the confirmation, about the instruction
            return {"effector": meaning.effector, "task": meaning.task}
        if tag == "analyze":
            spans = [find_span(words, phrase) for phrase in meaning.things]
            return {"position": meaning.position, "objects": spans}
        if tag == "relative" and meaning.side is not None:
            x, y = BESIDE[meaning.side]
            return {"x": x, "y": y}
        if tag == "objects":
            return {"objects": []}
        if tag == "correct" and isinstance(said, Saying):
            return {"x": f"target.u{said.du:+.1f}", "y": f"target.v{said.dv:+.1f}"}
        raise RefusedError(f"no answer to '{tag[:40]}': start the dialogue with --prompts embedded")


def find_span(numbered: str, phrase: str) -> str:
    """Return where a phrase is in `the1 red2 cup3`: `2-3`. Raises RefusedError."""
    words = [word.rstrip(",").rstrip("0123456789") for word in numbered.split()]
    wanted = phrase.lower().split()
    for start in range(len(words) - len(wanted) + 1):
        if [word.rstrip(",") for word in words[start : start + len(wanted)]] == wanted:
            return f"{start + 1}-{start + len(wanted)}"
    raise RefusedError(f"'{phrase}' is not in '{numbered}'")


def _module(said: Prompt | Saying | Yes | None) -> str:
    if isinstance(said, Prompt):
        return "prediction"
    if isinstance(said, Saying):
        return "correction"
    if isinstance(said, Yes):
        return "confirmation"
    raise RefusedError("nothing was announced that this could be about")
