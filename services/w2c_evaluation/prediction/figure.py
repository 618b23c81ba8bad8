"""Success rates as a figure, and pictures of hits and misses."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from w2c.errors import ConfigError
from w2c.extras import needs_extra
from w2c_evaluation.benchmark.dataset import Item
from w2c_evaluation.benchmark.drawing import (
    Picture,
    captioned,
    encoded,
    sheet,
    tinted,
    with_box,
    with_point,
)
from w2c_evaluation.benchmark.record import POSITIONS
from w2c_evaluation.prediction.judging import Answer
from w2c_evaluation.prediction.report import Rates

SHOWN = 12
"""Hits and misses of each combination"""
COLOURS = {"absolute": "#3b6fb6", "relative": "#d98f2b"}


def write_figure(rates: Mapping[str, Rates], random: Rates, path: Path) -> None:
    """Write bars of absolute and relative success with their quartiles; the same bytes again.

    Args:
        rates: Label of a combination -> its rates.
        random: Of points by chance: dashed lines.
        path: Of the SVG file.

    Raises:
        ConfigError: it cannot be written.
    """
    with needs_extra("evaluation"):
        import matplotlib as mpl

        mpl.use("Agg")
        from matplotlib import pyplot as plt
    settings: Any = {"svg.hashsalt": "w2c", "svg.fonttype": "none", "font.size": 9}
    with mpl.rc_context(settings):
        figure, axes = plt.subplots(figsize=(7.0, 1.2 + 0.5 * max(1, len(rates))))
        places = np.arange(len(rates))
        for number, name in enumerate(POSITIONS):
            known = [one.get(name, ()) for one in rates.values()]
            spread = [np.percentile(v, (50, 25, 75)) if len(v) else (0, 0, 0) for v in known]
            medians, low, high = np.array(spread).reshape(-1, 3).T
            axes.barh(
                places + 0.38 * number,
                medians,
                0.36,
                xerr=np.vstack([medians - low, high - medians]),
                color=COLOURS[name],
                label=name,
            )
            if len(random.get(name, ())):
                axes.axvline(
                    float(np.median(random[name])), color=COLOURS[name], ls="--", lw=1,
                )  # fmt: skip
        axes.set_yticks(places + 0.19, list(rates))
        axes.invert_yaxis()
        axes.set_xlim(0.0, 1.0)
        axes.set_xlabel("share of accepted points; dashed: points by chance")
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
        figure.tight_layout()
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            figure.savefig(path, format="svg", metadata={"Date": None})
        except OSError as error:
            raise ConfigError(f"{path} cannot be written: {error}; choose another") from error
        finally:
            plt.close(figure)


def write_examples(answers: Sequence[Answer], items: Sequence[Item], directory: Path) -> None:
    """Write hits.jpg and misses.jpg of one combination, of its first repetition."""
    by_id = {item.record.id: item for item in items}
    directory.mkdir(parents=True, exist_ok=True)
    for name, wanted in (("hits", True), ("misses", False)):
        chosen = [a for a in answers if a.hit == wanted and a.repetition == 0][:SHOWN]
        if chosen:
            drawn = [draw(by_id[answer.id], answer) for answer in chosen]
            (directory / f"{name}.jpg").write_bytes(encoded(".jpg", sheet(drawn, 3), 85))


def draw(item: Item, answer: Answer) -> Picture:
    """Return the picture of a prompt with accepted area, boxes, point, and what was heard."""
    data = np.frombuffer(item.picture(), np.uint8)
    picture = tinted(np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), np.uint8), item.accepted())
    for box in answer.boxes:
        picture = with_box(picture, box)
    if answer.point is not None:
        picture = with_point(picture, answer.point, hit=answer.hit)
    heard = f"{answer.position}: {', '.join(answer.phrases)}" if answer.phrases else "nothing heard"
    failed = "" if answer.hit else f" - {answer.error}"
    return captioned(picture, [f"{item.record.id}  {item.record.prompt}", f"{heard}{failed}"], 480)
