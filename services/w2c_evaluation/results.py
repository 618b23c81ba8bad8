"""The one shape of results files, so that tables, figures and checks are functions of it."""

import json
import os
import platform
import subprocess
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from w2c.errors import ConfigError

PACKAGES = ("words2contact", "mujoco", "pin", "torch", "transformers", "llama-cpp-python")


def row(
    case: str, metric: str, values: Sequence[float], unit: str, n: int | None = None
) -> dict[str, Any]:
    """Return one row: the median of the values and its quartiles; NaN without values."""
    array = np.asarray(values, dtype=np.float64)
    median, low, high = (
        np.percentile(array, (50, 25, 75)).tolist() if array.size else [float("nan")] * 3
    )
    return {
        "case": case,
        "metric": metric,
        "value": median,
        "unit": unit,
        "n": array.size if n is None else n,
        "spread": [low, high],
    }


def make_results(benchmark: str, seed: int, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return a results document for this commit and machine."""
    return {
        "benchmark": benchmark,
        "commit": _commit(),
        "seed": seed,
        "versions": {name: _version(name) for name in PACKAGES},
        "machine": {
            "processor": _processor(),
            "cores": os.cpu_count(),
            "system": platform.platform(),
            "python": platform.python_version(),
        },
        "rows": rows,
    }


def write_results(results: dict[str, Any], path: Path) -> None:
    """Write a results document as JSON. Raises ConfigError where that cannot be."""
    write_text(json.dumps(results, indent=2) + "\n", path)


def write_text(text: str, path: Path) -> None:
    """Write a file, and the directories to it. Raises ConfigError where that cannot be."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    except OSError as error:
        raise ConfigError(
            f"{path} cannot be written: {error.strerror}; choose another file, or free some space"
        ) from error


def _commit() -> str:
    try:
        answer = subprocess.run(
            ["git", "describe", "--always", "--dirty"], capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return answer.stdout.strip()


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def results_table(results: dict[str, Any]) -> str:
    """Return the results as a Markdown table, with where they come from."""
    lines = ["| case | metric | value | n |", "|---|---|---|---|"]
    for entry in results["rows"]:
        low, high = entry["spread"]
        value = f"{entry['value']:.4g}"
        spread = "" if low == high else f" [{low:.4g}, {high:.4g}]"
        text = f"{value}{spread} {entry['unit']}"
        lines.append(f"| {entry['case']} | {entry['metric']} | {text} | {entry['n']} |")
    return "\n".join([*lines, "", origin(results)])


def origin(results: dict[str, Any]) -> str:
    """Return in one line where results come from."""
    machine = results["machine"]
    return (
        f"Commit `{results['commit']}`, first seed {results['seed']}, "
        f"{machine['processor']}, {machine['cores']} cores."
    )
