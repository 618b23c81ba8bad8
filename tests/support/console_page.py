"""What the browser tests do with the operator's page."""

from typing import Any

from fakes.table_picture import HEIGHT, WIDTH


def dot_on_picture(page: Any) -> tuple[float, float]:
    """Return where the middle of the dot is, in pixels of the picture as drawn on the screen."""
    canvas = page.locator("canvas").bounding_box()
    dot = page.get_by_role("img", name="target").locator(".dot").bounding_box()
    u = (dot["x"] + dot["width"] / 2 - canvas["x"]) / canvas["width"] * WIDTH
    v = (dot["y"] + dot["height"] / 2 - canvas["y"]) / canvas["height"] * HEIGHT
    return u, v


def picture_shown(page: Any) -> None:
    """Wait until there is a picture."""
    page.get_by_label("Age of the picture").get_by_text("old").wait_for()


def say(page: Any, text: str) -> None:
    page.get_by_label("Instruction").fill(text)
    page.get_by_role("button", name="Send").click()
