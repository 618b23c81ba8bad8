"""Tables of lifted pixels."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from w2c_evaluation.perception.trial import SAME_SURFACE, PixelResult, SceneResult
from w2c_evaluation.results import origin, row

TARGETS = {
    ("all", "point_error_median"): 1.5,
    ("load_bearing", "point_error_p95"): 6.0,
    ("all", "normal_error_median"): 2.0,
    ("all", "time_median"): 10.0,
}
"""(case, metric): limit, in the unit of its row"""
LOAD_BEARING = ("carries", "load_bearing")
ROOM = "room"


def make_rows(results: Sequence[SceneResult]) -> list[dict[str, Any]]:
    """Return the rows of the results file: all pixels, then those of each kind of surface."""
    pixels = [pixel for result in results for pixel in result.pixels]
    rows = _rows("all", pixels)
    for case in ("load_bearing", "room", "other_things"):
        some = [pixel for pixel in pixels if case_of(pixel.support) == case]
        if some:
            rows += _rows(case, some)
    return rows


def case_of(support: str) -> str:
    """Return the case that a pixel counts for beside `all`, by how its surface carries."""
    if support in LOAD_BEARING:
        return "load_bearing"
    return "room" if support == ROOM else "other_things"


def _rows(case: str, pixels: Sequence[PixelResult]) -> list[dict[str, Any]]:
    answered = [pixel for pixel in pixels if not pixel.refusal]
    camera = [1e3 * pixel.camera_error for pixel in answered]
    world = [1e3 * pixel.world_error for pixel in answered]
    normal = [float(np.degrees(pixel.normal_error)) for pixel in answered]
    return [
        row(case, "point_error_median", camera, "mm"),
        _percentile(case, "point_error_p95", camera, "mm"),
        row(case, "world_error_median", world, "mm"),
        _percentile(case, "world_error_p95", world, "mm"),
        row(case, "normal_error_median", normal, "deg"),
        _percentile(case, "normal_error_p95", normal, "deg"),
        row(case, "bound_median", [1e3 * pixel.camera_bound for pixel in answered], "mm"),
        row(case, "world_bound_median", [1e3 * pixel.world_bound for pixel in answered], "mm"),
        _share(case, "bound_covers", [p.camera_error <= p.camera_bound for p in answered]),
        _share(case, "world_bound_covers", [p.world_error <= p.world_bound for p in answered]),
        _share(case, "refused", [bool(p.refusal) for p in pixels]),
        _share(case, "refused_wrongly", [bool(p.refusal) and p.known for p in pixels]),
        _share(case, "other_surface", [p.camera_error > SAME_SURFACE for p in answered]),
        row(case, "time_median", [pixel.milliseconds for pixel in pixels], "ms"),
        _percentile(case, "time_p95", [pixel.milliseconds for pixel in pixels], "ms"),
        row(case, "time_again_median", [pixel.milliseconds_again for pixel in pixels], "ms"),
        _percentile(case, "time_again_p95", [pixel.milliseconds_again for pixel in pixels], "ms"),
    ]


def _percentile(case: str, metric: str, values: Sequence[float], unit: str) -> dict[str, Any]:
    value = float(np.percentile(values, 95)) if len(values) else float("nan")
    return row(case, metric, [value], unit, n=len(values))


def _share(case: str, metric: str, found: Sequence[bool]) -> dict[str, Any]:
    share = float(np.mean(found)) if len(found) else float("nan")
    return row(case, metric, [share], "rate", n=len(found))


def format_table(results: dict[str, Any]) -> str:
    """Return the results as a Markdown table, one line a metric, and where they come from."""
    rows = results["rows"]
    cases = list(dict.fromkeys(entry["case"] for entry in rows))
    values = {(entry["case"], entry["metric"]): entry for entry in rows}
    head = " | ".join(
        f"{case.replace('_', ' ')} ({values[case, 'refused']['n']})" for case in cases
    )
    lines = [f"| metric | {head} |", "|---" * (len(cases) + 1) + "|"]
    for metric, unit in dict.fromkeys((entry["metric"], entry["unit"]) for entry in rows):
        shown = " | ".join(f"{values[case, metric]['value']:.3g}" for case in cases)
        lines.append(f"| {metric.replace('_', ' ')} [{unit}] | {shown} |")
    return "\n".join([*lines, "", origin(results)])


def missed(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Return the targets that are not met, in words; those without values are not."""
    values = {(entry["case"], entry["metric"]): entry for entry in rows}
    complaints = []
    for (case, metric), limit in TARGETS.items():
        entry = values.get((case, metric))
        if entry is None or not entry["value"] <= limit:
            found = "nothing" if entry is None else f"{entry['value']:.3g} {entry['unit']}"
            complaints.append(f"{case} {metric}: {found}, limit {limit:g}")
    return complaints
