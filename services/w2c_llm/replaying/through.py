"""`w2c replay FILE --through llm`: the same questions once more, compared by score.

Texts and values must be the same; the probabilities of options may differ by a little: what is
reused of earlier prompts, and the processor, round them otherwise. The model is the one that the
recorded process ran, by its configuration.
"""

from collections.abc import Iterator
from dataclasses import asdict

from w2c.clock import RealClock
from w2c.difference import INFINITE, Difference, differences
from w2c.errors import ConfigError, W2CError
from w2c.messages import ChooseReply, ChooseRequest, CompleteReply, CompleteRequest
from w2c.through import Asked, Compared, Session, Skipped, configuration
from w2c_llm import answering
from w2c_llm.backend import Backend, Budget
from w2c_llm.config import LlmConfig
from w2c_llm.node import make_backend

TOLERANCE = 0.01
"""Of a probability"""
AT_A_SERVER = "openai"
QUESTIONS = CompleteRequest | ChooseRequest
ANSWERS = CompleteReply | ChooseReply


def through(session: Session, tolerance: float | None) -> Iterator[Compared | Skipped]:
    """Ask the recorded questions again. See `w2c.through.Through`."""
    config = configuration(session, "llm", LlmConfig)
    if config.backend == AT_A_SERVER:
        raise ConfigError(
            f"the recorded answers are of '{config.model}' at {config.openai_url}: a server is not "
            "asked again, which may cost money"
        )
    backend = make_backend(config)
    try:
        backend.warm_up()
        for asked in session.asked("llm"):
            yield _ask(backend, asked, TOLERANCE if tolerance is None else tolerance)
    finally:
        backend.close()


def _ask(backend: Backend, asked: Asked, tolerance: float) -> Compared | Skipped:
    stream, request, reply = f"llm/{asked.method}", asked.request, asked.reply
    if not (isinstance(request, QUESTIONS) and isinstance(reply, ANSWERS)):
        return Skipped(stream, asked.seconds, f"it was not answered then: {asked.outcome}")
    recorded = {"model": reply.model, **_content(reply)}
    try:
        made = {"model": backend.name, **_answer(backend, request)}
        found = list(differences(recorded, made))
    except W2CError as error:
        found = [Difference("", "an answer", str(error), INFINITE)]
    last = request.messages[-1].content
    inputs = (f"{request.messages[0].content[:60]!r} ... {last[-300:]!r}",)
    return Compared(stream, f"'{last[-60:]}'", asked.seconds, found, tolerance, inputs)


def _answer(backend: Backend, request: CompleteRequest | ChooseRequest) -> dict[str, object]:
    budget = Budget(RealClock(), LlmConfig(robot="replay").deadline)
    if isinstance(request, CompleteRequest):
        answer = asdict(answering.complete(backend, request, budget))
        return {"text": answer["text"], "value": answer["value"]}
    choice = answering.choose(backend, request, budget)
    return {"option": choice.option, "probabilities": choice.probabilities}


def _content(reply: CompleteReply | ChooseReply) -> dict[str, object]:
    """Return what an answer says, without what it cost."""
    if isinstance(reply, CompleteReply):
        return {"text": reply.text, "value": reply.value}
    return {"option": reply.option, "probabilities": reply.probabilities}
