"""What the operator of scenario (a) answers where the robot asks."""

from collections.abc import Mapping

from w2c.geometry import Intrinsics, Vector, apply, inverse
from w2c.messages import CameraView
from w2c_evaluation.demo.scenario import Line
from w2c_evaluation.scenarios.answering import SLACK_CM, Question, Wish, choose_option


def answer_for(
    question: Question, line: Line, places: Mapping[str, Vector], view: CameraView
) -> str | None:
    """Return the option that says what a line means; None: none of them does.

    Args:
        question: What the robot asks.
        line: What it was asked about.
        places: Points (3,) of the things in the world [m].
        view: Of the picture that was spoken about, or of a later one: the robot stands still.

    Raises:
        GeometryError: the thing is behind the camera.
    """
    if line.wanted is None:
        return None
    point = apply(inverse(view.world_from_camera), places[line.wanted])
    camera = Intrinsics(*view.intrinsics)
    reach = SLACK_CM * 0.01 * camera.fx / float(point[2])
    wish = Wish(camera.pixel_from_point(point), reach, changes=line.changes)
    return choose_option(question, wish)
