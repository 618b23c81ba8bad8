"""What a played story was, for a person and as `summary.json`."""

from typing import Any

from w2c_evaluation.scenarios.record import Boxes, RunResult, Understood

BOXES_FROM_TRUTH = (
    "NOTE                 things were found by the simulator's truth, not by the grounding model"
)


def make_summary(result: RunResult, boxes: Boxes, recording: str) -> dict[str, Any]:
    """Return the summary in the shape of that of the first demo, with the corrections."""
    turns = [turn for turns in result.turns for turn in turns]
    return {
        "scene": result.scenario,
        "seed": result.seed,
        "boxes": boxes,
        "turns": [
            {
                "text": turn.text,
                "kind": turn.kind,
                "module": turn.module,
                "point": None if turn.pixel is None else [round(x, 1) for x in turn.pixel],
                "seconds": round(turn.seconds, 3),
            }
            for turn in turns
        ],
        "place_error_mm": list(result.place_errors_mm),
        "end_effector_error_mm": list(result.hand_errors_mm),
        "support_force_N": [round(force, 1) for force in result.support_force_n],
        "fell": result.fell,
        "recording": recording,
        "problem": "; ".join(result.problems),
        "cause": result.cause,
    }


def format_story(result: RunResult, boxes: Boxes, recording: str, afterwards: str = "") -> str:
    """Return the same for the terminal; `afterwards`: what was done after the words."""
    turns = [turn for turns in result.turns for turn in turns]
    width = max([*(len(_said(turn)) for turn in turns), len("said")])
    lines = ["", f"{'said':<{width}} {'understood as':<20} {'point':<15} time"]
    lines += [_line(turn, width) for turn in turns]
    errors = ", ".join(f"{error:.0f} mm" for error in result.hand_errors_mm) or "-"
    lines += ["", f"hand from its place  {errors}"]
    if result.support_force_n:
        low, middle, _ = result.support_force_n
        lines.append(f"support while it reaches  {middle:.0f} N, {low:.0f} N at the least 5 %")
    if afterwards and result.succeeded:
        lines.append(f"then                 {afterwards}")
    lines += [
        f"fell                 {'yes' if result.fell else 'no'}",
        f"recording            {recording}",
    ]
    if boxes == "truth":
        lines.append(BOXES_FROM_TRUTH)
    if result.problems:
        lines.append(f"PROBLEM              {'; '.join(result.problems)} (from {result.cause})")
    return "\n".join(lines)


def _said(turn: Understood) -> str:
    return "(the button)" if turn.kind == "button" else turn.text


def _line(turn: Understood, width: int) -> str:
    point = "-" if turn.pixel is None else f"({turn.pixel[0]:.0f}, {turn.pixel[1]:.0f})"
    return f"{_said(turn):<{width}} {turn.module or '-':<20} {point:<15} {turn.seconds:.2f} s"
