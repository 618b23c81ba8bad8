"""Comparisons of two ways to ask as rows and a table, and what misses its target."""

from collections.abc import Sequence
from typing import Any

from w2c_evaluation.language.instruction import ServiceCost
from w2c_evaluation.results import origin, row

ALL = "all"
EMBEDDED = "embedded."
"""Before the cases of the embedded model; those of the large one have no prefix"""
LEAST = {
    (ALL, "token_ratio"): 15.0,
    (ALL, "speedup"): 5.0,
    (EMBEDDED + ALL, "token_ratio"): 15.0,
    (EMBEDDED + ALL, "speedup"): 2.5,
}
MOST = {("instruction", "milliseconds"): 300.0, ("service", "idle_memory_mb"): 400.0}


def comparison_rows(comparison: Any, prefix: str = "") -> list[dict[str, Any]]:
    """Return the rows of one model: each kind of question, and all of them."""
    pairs = comparison.pairs
    rows = []
    for case in dict.fromkeys(pair.case for pair in pairs):
        rows += _case_rows(prefix + case, [pair for pair in pairs if pair.case == case])
    rows += _case_rows(prefix + ALL, pairs)
    first = [cost.milliseconds for cost in comparison.first]
    return [*rows, row(prefix + ALL, "first_ms", first, "ms")]


def _case_rows(case: str, pairs: Sequence[Any]) -> list[dict[str, Any]]:
    plain, ours = [pair.plain for pair in pairs], [pair.ours for pair in pairs]
    return [
        row(case, "plain_ms", [cost.milliseconds for cost in plain], "ms"),
        row(case, "ours_ms", [cost.milliseconds for cost in ours], "ms"),
        row(case, "plain_tokens", [float(cost.prompt_tokens) for cost in plain], "tokens"),
        row(case, "ours_tokens", [float(cost.prompt_tokens) for cost in ours], "tokens"),
        row(case, "plain_answer_tokens", [float(cost.answer_tokens) for cost in plain], "tokens"),
        row(case, "ours_answer_tokens", [float(cost.answer_tokens) for cost in ours], "tokens"),
        row(case, "token_ratio", _ratios(plain, ours, "prompt_tokens"), "x"),
        row(case, "speedup", _ratios(plain, ours, "milliseconds"), "x"),
        row(
            case,
            "same_answers",
            [sum(pair.plain.text == pair.ours.text for pair in pairs) / len(pairs)],
            "rate",
            n=len(pairs),
        ),
    ]


def _ratios(plain: Sequence[Any], ours: Sequence[Any], name: str) -> list[float]:
    return [getattr(a, name) / getattr(b, name) for a, b in zip(plain, ours, strict=True)]


def service_rows(cost: ServiceCost) -> list[dict[str, Any]]:
    """Return the rows of the service with the embedded model."""
    return [
        row("instruction", "milliseconds", cost.instructions_ms, "ms"),
        row("instruction", "cpu_ms", [cost.cpu_ms], "ms", n=len(cost.instructions_ms)),
        row("service", "idle_memory_mb", [cost.idle_memory_mb], "MB"),
    ]


def missed(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Return the targets that are not met, in words; what was not measured misses nothing."""
    values = {(entry["case"], entry["metric"]): entry["value"] for entry in rows}
    wrong = [
        (key, f"below {limit:g}")
        for key, limit in LEAST.items()
        if key in values and not values[key] >= limit
    ]
    wrong += [
        (key, f"above {limit:g}")
        for key, limit in MOST.items()
        if key in values and not values[key] <= limit
    ]
    return [f"{case} {metric}: {values[case, metric]:.3g}, {how}" for (case, metric), how in wrong]


def format_table(results: dict[str, Any]) -> str:
    """Return the results as Markdown: a line a kind of question, and where they come from."""
    values = {(entry["case"], entry["metric"]): entry for entry in results["rows"]}
    columns = (
        "plain_ms",
        "ours_ms",
        "speedup",
        "plain_tokens",
        "ours_tokens",
        "plain_answer_tokens",
        "ours_answer_tokens",
        "same_answers",
    )
    names = "plain [ms] | ours [ms] | speedup | plain [tokens] | ours [tokens]"
    cases = list(dict.fromkeys(case for case, metric in values if metric == "speedup"))
    lines = [
        f"| questions | {names} | plain, answer | ours, answer | same answers |",
        "|---" * (len(columns) + 1) + "|",
    ]
    lines = lines if cases else []
    for case in cases:
        shown = " | ".join(f"{values[case, metric]['value']:.3g}" for metric in columns)
        lines.append(f"| {case} ({values[case, 'speedup']['n']}) | {shown} |")
    instruction = values.get(("instruction", "milliseconds"))
    memory = values.get(("service", "idle_memory_mb"))
    if instruction and memory:
        low, high = instruction["spread"]
        lines += [
            "",
            f"A whole instruction with the embedded model: {instruction['value']:.0f} ms "
            f"[{low:.0f}, {high:.0f}], n = {instruction['n']}, of which the service computes "
            f"{values['instruction', 'cpu_ms']['value']:.0f} ms. Resident memory of the idle "
            f"service: {memory['value']:.0f} MB.",
        ]
    return "\n".join([*lines, "", origin(results)])
