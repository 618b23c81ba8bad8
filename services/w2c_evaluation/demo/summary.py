"""`summary.json` of a demo, and the same for a person."""

import json
from pathlib import Path
from typing import Any

from w2c.messages import ControllerStatus
from w2c_evaluation.demo.operator import LineResult

LATENESS = ("p50", "p99", "max", "gaps_20ms")


def make_summary(
    results: list[LineResult],
    status: ControllerStatus | None,
    *,
    fell: bool,
    recording: str,
    problem: str = "",
) -> dict[str, Any]:
    """Return the summary in the shape that tables and checks rely upon."""
    motions = [result for result in results if result.event is not None]
    contacts = [r for r in motions if r.event is not None and r.event.task == "contact"]
    reaches = [r for r in motions if r.event is not None and r.event.task == "reach"]
    lateness = {} if status is None else status.lateness_us
    return {
        "turns": [
            {
                "text": result.turn.text,
                "module": result.turn.module,
                "point": _point(result),
                "seconds": round(result.turn.seconds, 3),
            }
            for result in results
        ],
        "end_effector_error_mm": _rounded(reaches[-1].error_m * 1e3) if reaches else None,
        "hand_force_N": _rounded(contacts[-1].force_n) if contacts else None,
        "fell": fell,
        "lateness_us": {name: _rounded(lateness.get(name)) for name in LATENESS},
        "recording": recording,
        "problem": problem,
    }


def _point(result: LineResult) -> list[float] | None:
    """Return the pixel that the line led to."""
    target = result.turn.target
    return None if target is None else [round(target.u, 1), round(target.v, 1)]


def _rounded(value: float | None) -> float | None:
    return None if value is None or value != value else round(float(value), 1)  # noqa: PLR0124


def write_summary(summary: dict[str, Any], path: Path) -> None:
    """Write the summary as JSON."""
    path.write_text(json.dumps(summary, indent=2) + "\n")


def format_summary(summary: dict[str, Any]) -> str:
    """Return the summary for the terminal."""
    lines = ["", f"{'utterance':<44} {'module':<20} {'point':<15} time"]
    for turn in summary["turns"]:
        point = (
            "-" if turn["point"] is None else f"({turn['point'][0]:.0f}, {turn['point'][1]:.0f})"
        )
        lines.append(f"{turn['text']:<44} {turn['module']:<20} {point:<15} {turn['seconds']:.2f} s")
    late = summary["lateness_us"]
    lines += [
        "",
        f"hand force           {_with_unit(summary['hand_force_N'], 'N')}",
        f"end-effector error   {_with_unit(summary['end_effector_error_mm'], 'mm')}",
        f"fell                 {'yes' if summary['fell'] else 'no'}",
        f"loop lateness        p50 {late['p50']} us, p99 {late['p99']} us, max {late['max']} us, "
        f"gaps over 20 ms: {late['gaps_20ms']}",
        f"recording            {summary['recording']}",
    ]
    if summary["problem"]:
        lines.append(f"PROBLEM              {summary['problem']}")
    return "\n".join(lines)


def _with_unit(value: float | None, unit: str) -> str:
    return "-" if value is None else f"{value} {unit}"
