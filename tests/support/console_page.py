"""What the browser tests do with the operator's page."""

from typing import Any

from fakes.table_picture import HEIGHT, WIDTH
from support.waiting import wait_until


def box_of(locator: Any) -> dict[str, float]:
    """Return the box of an element that the page may be drawing anew at this moment."""
    boxes: list[dict[str, float]] = []

    def is_drawn() -> bool:
        box = locator.bounding_box()
        if box is not None:
            boxes.append(box)
        return box is not None

    wait_until(is_drawn)
    return boxes[-1]


def dot_on_picture(page: Any) -> tuple[float, float]:
    """Return where the middle of the dot is, in pixels of the picture as drawn on the screen."""
    canvas = box_of(page.locator("#canvas"))
    dot = box_of(page.get_by_role("img", name="target").locator(".dot"))
    u = (dot["x"] + dot["width"] / 2 - canvas["x"]) / canvas["width"] * WIDTH
    v = (dot["y"] + dot["height"] / 2 - canvas["y"]) / canvas["height"] * HEIGHT
    return u, v


def picture_shown(page: Any) -> None:
    """Wait until there is a picture."""
    page.get_by_label("Age of the picture").get_by_text("old").wait_for()


def say(page: Any, text: str) -> None:
    page.get_by_label("Instruction").fill(text)
    page.get_by_role("button", name="Send").click()
