"""Tables and rows of the results: Table I of the paper, where errors came from, and groups."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from w2c_evaluation.benchmark.dataset import Item
from w2c_evaluation.benchmark.record import POSITIONS, Origin, Record
from w2c_evaluation.prediction import paper
from w2c_evaluation.prediction.combinations import Combination
from w2c_evaluation.prediction.judging import STEPS, Answer
from w2c_evaluation.results import row
from w2c_evaluation.understanding.commands import wilson_interval

COLUMNS = (*POSITIONS, "overall")
RANDOM = "random points"
GROUPS: dict[str, Callable[[Origin], str]] = {
    "naming": lambda origin: origin.naming,
    "kind": lambda origin: "never trained on" if origin.held_out else "trained on",
    "two of a kind": lambda origin: "asked for one of two" if origin.attribute else "only one",
    "look": lambda origin: origin.look,
    "limb": lambda origin: origin.end_effector.partition("_")[2],
}

Rates = Mapping[str, Sequence[float]]
"""absolute, relative, overall -> rate of each repetition"""


def rates_of(answers: Sequence[Answer], records: Mapping[str, Record]) -> dict[str, list[float]]:
    """Return the success rates of one combination, repetition by repetition."""
    rates: dict[str, list[float]] = {name: [] for name in COLUMNS}
    for repetition in sorted({answer.repetition for answer in answers}):
        of_one = [answer for answer in answers if answer.repetition == repetition]
        for name in COLUMNS:
            hits = [a.hit for a in of_one if name in ("overall", records[a.id].position)]
            if hits:
                rates[name].append(sum(hits) / len(hits))
    return {name: values for name, values in rates.items() if values}


def make_rows(
    answers: Mapping[Combination, Sequence[Answer]], random: Rates, items: Sequence[Item]
) -> list[dict[str, Any]]:
    """Return the rows of the results file."""
    records = {item.record.id: item.record for item in items}
    rows = []
    for combination, given in answers.items():
        label = combination.label
        for name, values in rates_of(given, records).items():
            count = sum(name in ("overall", record.position) for record in records.values())
            rows.append(row(label, f"success.{name}", values, "rate", n=count))
        errors = Counter(answer.error for answer in given if not answer.hit)
        for step in STEPS:
            share = errors[step] / len(given)
            rows.append(row(label, f"error.{step}", [share], "rate", n=len(given)))
        asked = sum(answer.asks for answer in given) / len(given)
        rows.append(row(label, "asks", [asked], "rate", n=len(given)))
        for group, hits in groups_of(given, records).items():
            rows.append(row(label, f"group.{group}", [float(np.mean(hits))], "rate", n=len(hits)))
    for name, by_chance in random.items():
        rows.append(row(RANDOM, f"success.{name}", by_chance, "rate", n=len(items)))
    return rows


def groups_of(answers: Sequence[Answer], records: Mapping[str, Record]) -> dict[str, list[bool]]:
    """Return hits by group, of pictures that say how they were made."""
    groups: dict[str, list[bool]] = {}
    for name, of in GROUPS.items():
        for answer in answers:
            origin = records[answer.id].origin
            if origin is not None:
                groups.setdefault(f"{name}: {of(origin)}", []).append(answer.hit)
    return dict(sorted(groups.items()))


def format_tables(
    answers: Mapping[Combination, Sequence[Answer]],
    random: Rates,
    items: Sequence[Item],
    absent: Mapping[Combination, str],
) -> str:
    """Return everything as Markdown."""
    records = {item.record.id: item.record for item in items}
    parts = [success_table(answers, random, records), paper_note()]
    if answers:
        parts += ["## Where misses came from", error_table(answers)]
    groups = group_table(answers, records)
    if groups:
        parts += ["## By group", groups]
    if absent:
        lines = [f"- {combination.label}: {reason}" for combination, reason in absent.items()]
        parts += ["## Not there", "\n".join(lines)]
    return "\n\n".join(parts)


def success_table(
    answers: Mapping[Combination, Sequence[Answer]],
    random: Rates,
    records: Mapping[str, Record],
) -> str:
    """Return the paper's Table I of these combinations, points by chance in the last row."""
    head = ["LLM", "detection", "segmentation", *COLUMNS, "95 % of overall", "paper, photographs"]
    lines = [_line(head), "|" + "---|" * len(head)]
    for combination, given in answers.items():
        rates = rates_of(given, records)
        first = [answer for answer in given if answer.repetition == 0] or list(given)
        low, high = wilson_interval(sum(answer.hit for answer in first), len(first))
        theirs = paper.TABLE.get(combination.names)
        cells = [*combination.names, *(_cell(rates.get(name, ())) for name in COLUMNS)]
        cells += [f"{low:.2f} to {high:.2f}", " / ".join(f"{v:.2f}" for v in theirs or ())]
        lines.append(_line(cells))
    cells = [RANDOM, "", "", *(_cell(random.get(name, ())) for name in COLUMNS), ""]
    lines.append(_line([*cells, " / ".join(f"{value:.2f}" for value in paper.RANDOM)]))
    return "\n".join(lines)


def paper_note() -> str:
    """Return what the paper found, and that it is another task."""
    absolute, relative, overall = paper.TABLE[paper.BEST]
    return (
        f"The paper's best combination ({' + '.join(paper.BEST)}) reached {absolute} / {relative} "
        f"/ {overall} on 78 photographs. Unless the pictures here are those photographs, that is "
        "another task, and the figures do not compare."
    )


def error_table(answers: Mapping[Combination, Sequence[Answer]]) -> str:
    """Return how many prompts failed first at which step, of all repetitions."""
    head = ["combination", "prompts", "hits", *STEPS, "would ask"]
    lines = [_line(head), "|" + "---|" * len(head)]
    for combination, given in answers.items():
        errors = Counter(answer.error for answer in given if not answer.hit)
        cells = [combination.label, len(given), sum(answer.hit for answer in given)]
        cells += [errors[step] for step in STEPS]
        lines.append(_line([*cells, sum(answer.asks for answer in given)]))
    return "\n".join(lines)


def group_table(
    answers: Mapping[Combination, Sequence[Answer]], records: Mapping[str, Record]
) -> str:
    """Return success by group, groups down and combinations across; "" without groups."""
    columns = {one.label: groups_of(given, records) for one, given in answers.items()}
    names = sorted({name for groups in columns.values() for name in groups})
    if not names:
        return ""
    lines = [_line(["group", *columns]), "|" + "---|" * (len(columns) + 1)]
    for name in names:
        hits = [groups.get(name, []) for groups in columns.values()]
        lines.append(_line([name, *(f"{sum(h)}/{len(h)}" for h in hits)]))
    return "\n".join(lines)


def _cell(rates: Sequence[float]) -> str:
    if not len(rates):
        return "-"
    median, low, high = np.percentile(rates, (50, 25, 75))
    return f"{median:.2f} [{low:.2f}, {high:.2f}]"


def _line(cells: Sequence[object]) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"
