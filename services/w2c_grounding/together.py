"""Several requests about one picture as one."""

from typing import Protocol

import msgspec

from w2c.messages import GroundingReply, GroundingRequest


class AnswersOne(Protocol):
    """What answers a request."""

    def ground(self, request: GroundingRequest) -> GroundingReply:
        """Answer every phrase of a request."""


def ground_together(grounder: AnswersOne, requests: list[GroundingRequest]) -> list[GroundingReply]:
    """Return the reply to each request; a phrase that several ask for is asked once.

    Args:
        grounder: Answers them as one.
        requests: All about the same picture.

    Raises:
        W2CError: of the grounder; then none of the requests has an answer.
    """
    phrases = list(dict.fromkeys(phrase for request in requests for phrase in request.phrases))
    heatmaps = any(request.want == "heatmaps" for request in requests)
    one = GroundingRequest(
        jpeg=requests[0].jpeg, phrases=phrases, want="heatmaps" if heatmaps else "boxes"
    )
    reply = grounder.ground(one)
    found = {evidence.phrase: evidence for evidence in reply.evidence}
    bare = {
        phrase: msgspec.structs.replace(evidence, heatmap=None)
        for phrase, evidence in found.items()
    }
    return [
        msgspec.structs.replace(
            reply,
            evidence=[
                (found if request.want == "heatmaps" else bare)[phrase]
                for phrase in request.phrases
            ],
        )
        for request in requests
    ]
