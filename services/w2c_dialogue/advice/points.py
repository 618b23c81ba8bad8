"""The veto for points of the world, which no picture was clicked for."""

from w2c.bus import CallContext
from w2c.errors import RefusedError
from w2c.messages import Array, VetoReply, VetoRequest
from w2c_dialogue.advice.guard import Guard
from w2c_dialogue.frames import FrameStore, project
from w2c_dialogue.interfaces import Frame

VIEW_WAIT_S = 1.0
"""The first picture, or where its camera was, may still be on its way [s]"""


class PointVeto:
    """Looks at where a point is in the newest picture. Thread-safe."""

    def __init__(self, guard: Guard, frames: FrameStore) -> None:
        self._guard = guard
        self._frames = frames

    def answer(self, request: VetoRequest, _context: CallContext) -> VetoReply:
        """Return whether a point may be touched."""
        try:
            frame = self._frames.find(-1, wait_s=VIEW_WAIT_S)
        except RefusedError as error:
            return self._unseen(str(error))
        if frame.view is None:
            return self._unseen("perception does not say where the camera is")
        at = project(request.point, frame.view)
        if at is None:
            return VetoReply(note="The point is not in the picture: nobody looked what is there.")
        return self._look(frame, at, request.point)

    def _look(self, frame: Frame, at: tuple[float, float], point: Array) -> VetoReply:
        verdict = self._guard.verdict_at(frame, self._guard.place_at(frame, at, point))
        refusal = self._guard.refusal(verdict)
        if verdict.failure and not refusal:
            return VetoReply(note=f"Nobody looked for what must not be touched: {verdict.failure}.")
        return VetoReply(refusal=refusal)

    def _unseen(self, reason: str) -> VetoReply:
        """Return the answer where there is no picture to look at."""
        verdict = self._guard.without_picture(reason)
        refusal = self._guard.refusal(verdict)
        return VetoReply(refusal=refusal, note="" if refusal else reason)
