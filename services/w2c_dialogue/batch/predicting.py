"""One instruction about one picture, without a conversation: for the benchmark of the paper.

The modules are those of the robot's dialogue, in its order. Where the dialogue would ask which of
several things is meant, the best one is taken, as in the paper, and the answer says so.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from w2c.errors import DeadlineError, ModelError, RefusedError, RemoteError
from w2c.messages import Box, PhraseEvidence
from w2c_dialogue import absolute, relative, which
from w2c_dialogue.analyzer import analyze
from w2c_dialogue.frames import DEFAULT_PIXELS_PER_CM
from w2c_dialogue.interfaces import Frame, Grounding, LanguageModel
from w2c_dialogue.on_top import says_on_top
from w2c_dialogue.prompts.ablations import AblationName, ablated
from w2c_dialogue.prompts.sets import PROMPT_SETS, PromptSetName
from w2c_dialogue.prompts.single import AskedOnce
from w2c_dialogue.selector import select
from w2c_dialogue.sight import look, only, twins
from w2c_dialogue.utterance import Utterance, parse


@dataclass
class Predicted:
    """What became of an instruction, step by step."""

    module: str = ""
    """Of the selector"""
    position: str = ""
    """absolute or relative"""
    phrases: tuple[str, ...] = ()
    """For the objects, in order of mention"""
    boxes: tuple[Box, ...] = ()
    """The one that was chosen for each phrase that has one"""
    point: tuple[float, float] | None = None
    """(u, v) [px]"""
    asks: bool = False
    """The dialogue would have asked which of several things is meant"""
    failed: str = ""
    """selector, analyzer, segmentation, detection or expression: the step that gave up"""
    reason: str = ""
    steps: list[str] = field(default_factory=list)
    """That began"""


class Predicting:
    """The prediction module of the paper (Methods, "Prediction Module")."""

    def __init__(
        self,
        model: LanguageModel,
        grounding: Grounding,
        *,
        prompts: PromptSetName = "embedded",
        ablation: AblationName = "none",
    ) -> None:
        """Prepare.

        Raises:
            ConfigError: the prompt set has nothing that this ablation could take away.
        """
        self._model = AskedOnce(model) if ablation == "single_prompt" else model
        self._grounding = grounding
        self._prompts = ablated(PROMPT_SETS[prompts](), ablation)

    def predict(
        self,
        text: str,
        picture: bytes,
        size: tuple[int, int],
        pixels_per_cm: float = DEFAULT_PIXELS_PER_CM,
    ) -> Predicted:
        """Return the point that an instruction names.

        Args:
            text: The instruction.
            picture: JPEG or PNG.
            size: Its width and height [px].
            pixels_per_cm: How long a centimetre looks at the first thing, where that is known.

        Raises:
            CallError: a service cannot be asked. What it refuses, or fails at, is told in the
                answer.
        """
        answer = Predicted()
        frame = Frame(0, size[0], size[1], picture)
        try:
            self._follow(parse(text), frame, pixels_per_cm, answer)
        except (RefusedError, RemoteError, DeadlineError, ModelError) as error:
            answer.failed = answer.steps[-1] if answer.steps else "selector"
            answer.reason = str(error)
        return answer

    def _follow(
        self, utterance: Utterance, frame: Frame, pixels_per_cm: float, answer: Predicted
    ) -> None:
        answer.steps.append("selector")
        selection = select(self._model, self._prompts, utterance, has_target=False)
        answer.module = selection.module
        answer.steps.append("analyzer")
        analysis = analyze(self._model, self._prompts, utterance)
        answer.position = analysis.position
        answer.phrases = tuple(mention.phrase for mention in analysis.mentions)
        if not analysis.mentions:
            raise ModelError("no object was heard")
        absolutely = analysis.position == "absolute"
        mentions = analysis.mentions[:1] if absolutely else analysis.mentions
        answer.steps.append("segmentation" if absolutely else "detection")
        evidence = look(self._grounding, frame, mentions, "heatmaps" if absolutely else "boxes")
        settled = self._settled(evidence, frame, answer)
        answer.boxes = tuple(seen.boxes[0] for seen in settled if seen.boxes)
        if absolutely:
            on_top = says_on_top(utterance, mentions[0])
            prediction = absolute.predict(settled[0], frame, on_top=on_top)
        else:
            answer.steps.append("expression")
            prediction = relative.predict(
                self._model,
                self._prompts,
                frame,
                utterance=utterance,
                mentions=mentions,
                evidence=settled,
                grounding=self._grounding,
                pixels_per_cm=pixels_per_cm,
            )
        answer.point = prediction.u, prediction.v

    @staticmethod
    def _settled(
        evidence: Sequence[PhraseEvidence], frame: Frame, answer: Predicted
    ) -> list[PhraseEvidence]:
        """Return the evidence with one thing for each phrase."""
        settled = []
        for seen in evidence:
            boxes = twins(seen)
            if len(boxes) > 1:
                meant = which.read_phrase(seen.phrase, boxes)
                answer.asks = answer.asks or meant is None
                chosen = boxes[meant or 0]
                settled.append(only(seen, chosen, (frame.width, frame.height)))
            else:
                settled.append(seen)
        return settled
