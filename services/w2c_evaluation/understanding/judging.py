"""Whether an answer of the dialogue's modules is what a person meant."""

from collections.abc import Sequence
from typing import Any

import msgspec

Point = tuple[float, float]
Area = tuple[float, float, float, float]
"""left, top, right, bottom [px]"""


class Expectation(msgspec.Struct, frozen=True, kw_only=True):
    """What a line of a held-out file expects; the fields of its task are filled."""

    module: str = ""
    modules: list[str] = []
    position: str = ""
    objects: list[list[str]] = []
    """In order of mention, each with the spans that are right"""
    optional: list[str] = []
    """Spans that may be among the objects or not"""
    end_effector: str = ""
    task_type: str = ""
    accept: list[Area] = []
    reject: list[Area] = []


class HeldOut(msgspec.Struct, frozen=True, kw_only=True):
    """A line of a held-out file, beside what `dialogue batch` reads of it."""

    id: str
    task: str
    voice: str
    expect: Expectation


def score(line: HeldOut, answer: dict[str, Any]) -> dict[str, bool]:
    """Return what was judged and whether it is right; an error is wrong in all of it."""
    expect = line.expect
    match line.task:
        case "select":
            return {"select": answer.get("module") == expect.module}
        case "analyze":
            return {
                "analyze.position": answer.get("position") == expect.position,
                "analyze.objects": same_objects(answer.get("objects", ()), expect),
            }
        case "effector":
            return {
                "effector": (answer.get("end_effector"), answer.get("task_type"))
                == (expect.end_effector, expect.task_type)
            }
        case "relative" | "correct":
            return {line.task: is_accepted(answer.get("point"), expect)}
        case "dialogue":
            return {"dialogue": answer.get("modules") == expect.modules}
        case other:
            raise ValueError(f"line {line.id} has the task '{other}'")


def turns_right(line: HeldOut, answer: dict[str, Any]) -> list[bool]:
    """Return for each turn of a dialogue whether it went to the right module."""
    modules = answer.get("modules", [""] * len(line.expect.modules))
    return [a == b for a, b in zip(modules, line.expect.modules, strict=True)]


def same_objects(answered: Sequence[str], expect: Expectation) -> bool:
    """Say whether the objects are the expected ones, in order, and optional ones at most."""
    optional = {plain(span) for span in expect.optional}
    wanted = [{plain(span) for span in spans} for spans in expect.objects]
    at = 0
    for phrase in map(plain, answered):
        if at < len(wanted) and phrase in wanted[at]:
            at += 1
        elif phrase not in optional:
            return False
    return at == len(wanted)


def is_accepted(point: Any, expect: Expectation) -> bool:
    """Say whether a point lies in an accepted area and in no rejected one."""
    if not isinstance(point, (list, tuple)):
        return False
    return any(_inside(point, area) for area in expect.accept) and not any(
        _inside(point, area) for area in expect.reject
    )


def plain(phrase: str) -> str:
    """Return a phrase without case, outer punctuation and its article."""
    words = phrase.lower().strip(" .,;:!?\"'").split()
    return " ".join(words[1:] if len(words) > 1 and words[0] in ("the", "a", "an") else words)


def _inside(point: Sequence[float], area: Area) -> bool:
    left, top, right, bottom = area
    return left <= point[0] <= right and top <= point[1] <= bottom
