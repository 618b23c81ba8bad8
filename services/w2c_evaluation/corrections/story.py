"""A sheet of some trials: ring, dots in their order, and the words, for a person to look at."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from w2c_evaluation.corrections.eye import DOT_PX, RING_PX
from w2c_evaluation.corrections.pictures import Picture, read_picture
from w2c_evaluation.corrections.trial import Session, Study, Trial

Image = npt.NDArray[np.uint8]

COLUMNS, MOST = 3, 12
WIDTH, HEIGHT = 640, 360
LINE = 20
LINES = 6
GREEN, BLUE, YELLOW, WHITE = (80, 200, 60), (255, 90, 0), (0, 220, 255), (255, 255, 255)
"""BGR; the first dot is blue and corrected ones are yellow, as in the paper's figure 7"""


def draw_stories(study: Study, sessions: Sequence[Session], path: Path) -> None:
    """Draw the first trials of each phase, one of a session after the other."""
    trials = [
        (session, session.trials[index])
        for index in range(max((len(one.trials) for one in sessions), default=0))
        for session in sessions
        if index < len(session.trials)
    ][:MOST]
    tiles = [
        draw_trial(read_picture(study.pictures, trial.picture), session, trial)
        for session, trial in trials
    ]
    while len(tiles) % COLUMNS:
        tiles.append(np.zeros_like(tiles[0]))
    rows = [np.hstack(tiles[at : at + COLUMNS]) for at in range(0, len(tiles), COLUMNS)]
    if rows:
        path.parent.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(path), np.vstack(rows))


def draw_trial(picture: Picture, session: Session, trial: Trial) -> Image:
    """Return a trial over its picture, with its words below."""
    image = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise ValueError(f"picture {picture.name} cannot be decoded")
    _circle(image, trial.ring, RING_PX, GREEN, 2)
    before = None
    for number, prompt in enumerate(trial.prompts, 1):
        if prompt.point is None or prompt.point == before:
            continue
        _circle(image, prompt.point, DOT_PX, BLUE if before is None else YELLOW, -1)
        if before is not None:
            cv2.line(image, _whole(before), _whole(prompt.point), YELLOW, 1, cv2.LINE_AA)
        at = (int(prompt.point[0]) + 8, int(prompt.point[1]) - 6)
        cv2.putText(image, str(number), at, cv2.FONT_HERSHEY_SIMPLEX, 0.8, WHITE, 2, cv2.LINE_AA)
        before = prompt.point
    small = cv2.resize(image, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    words = np.zeros((LINE * LINES + 6, WIDTH, 3), np.uint8)
    lines = [f"{session.voice}, phase {session.phase}"]
    for number, prompt in enumerate(trial.prompts, 1):
        far = "no dot" if prompt.distance is None else f"{prompt.distance:.0f} px"
        lines.append(f"{number} {prompt.text[:62]} [{far}]")
    for index, text in enumerate(lines):
        at = (6, LINE * (index + 1) - 4)
        plain = text.encode("ascii", "replace").decode()
        cv2.putText(words, plain, at, cv2.FONT_HERSHEY_SIMPLEX, 0.45, WHITE, 1, cv2.LINE_AA)
    return np.asarray(np.vstack([small, words]), np.uint8)


def _circle(
    image: npt.NDArray[np.uint8] | cv2.typing.MatLike,
    centre: tuple[float, float],
    radius: float,
    colour: tuple[int, int, int],
    thickness: int,
) -> None:
    cv2.circle(image, _whole(centre), round(radius), colour, thickness, cv2.LINE_AA)


def _whole(pixel: tuple[float, float]) -> tuple[int, int]:
    return round(pixel[0]), round(pixel[1])
