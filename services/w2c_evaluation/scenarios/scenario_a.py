"""Scene (a): a book to lean on, and a cup out of reach."""

from pathlib import Path

from w2c_evaluation.demo import layout
from w2c_evaluation.scenarios.scenario import Meaning, Place, Prompt, Scenario


def _draw_layout(seed: int, scene_path: Path) -> str:
    return str(layout.draw_layout(seed, scene_path))


SCENARIO = Scenario(
    name="a",
    title="book and cup on a table",
    prompts=(
        Prompt(
            "Place your right hand on top of the book",
            Meaning("right_hand", "contact", "absolute", {"book": "book"}),
            Place("near the middle of the book", "book", spread=(0.12, 0.12, 0.0)),
        ),
        Prompt(
            "with your left hand, reach for the cup",
            Meaning("left_hand", "reach", "absolute", {"cup": "cup"}),
            Place("the middle of the cup as it is seen", "cup", share=(0.0, 0.0, 0.5)),
        ),
    ),
    draw_layout=_draw_layout,
)
