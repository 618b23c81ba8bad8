"""A conversation about one picture, in the caller's process, without a robot: for evaluation.

The modules are those of the robot's dialogue. What they ask of other services goes over the bus
that is given. Nothing is on the veto list: nothing moves here.
"""

from w2c.bus import Bus
from w2c.clock import RealClock
from w2c.messages import CameraView, SayRequest, Turn
from w2c_dialogue.advice.guard import Guard
from w2c_dialogue.advice.watch import Watch
from w2c_dialogue.frames import FrameStore
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.limbs import Limbs
from w2c_dialogue.pipeline import Dialogue
from w2c_dialogue.prompts.sets import PromptSetName, make_prompts
from w2c_dialogue.remote import RemoteServices


class Conversing:
    """The dialogue about one picture."""

    def __init__(
        self,
        bus: Bus,
        jpeg: bytes,
        view: CameraView,
        *,
        seed: int = 0,
        model_timeout_s: float = 30.0,
        prompts: PromptSetName = "embedded",
    ) -> None:
        """Begin.

        Args:
            bus: On which language model, grounding and perception answer.
            jpeg: The picture.
            view: From where it was taken; its stamp is the picture's.
            seed: Of the language model's answers.
            model_timeout_s: For each question to a model [s].
            prompts: Of the language model.
        """
        services = RemoteServices(bus, seed=seed, model_timeout_s=model_timeout_s)
        chosen = make_prompts(prompts)
        frames = FrameStore()
        frames.add_view(view)
        frames.add_frame(Frame(view.stamp_ns, view.width, view.height, jpeg))
        nothing = Watch(services.find, (), model_timeout_s)
        self._stamp_ns = view.stamp_ns
        self._dialogue = Dialogue(
            services,
            services,
            services,
            services,
            prompts=chosen,
            frames=frames,
            guard=Guard(nothing, (), share=0.3, margin=0.05, unchecked="refuse"),
            limbs=Limbs(chosen),
            clock=RealClock(),
            prefix="conversing",
        )

    def say(self, text: str, target_id: str = "") -> Turn:
        """Answer words of somebody who sees the picture, and the target of an id in it."""
        request = SayRequest(text=text, frame_stamp_ns=self._stamp_ns, target_id=target_id)
        return self._dialogue.say(request)
