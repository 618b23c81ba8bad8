"""Advice on a target, for the terminal."""

import time

from w2c.bus import Queue
from w2c.messages import Advice, Remark


def follow_advice(told: Queue[Advice], target_id: str, patience_s: float) -> list[str]:
    """Return what is told about a target until that is all, or patience ends; one line each.

    Args:
        told: What has been told since before the target was asked for.
        target_id: Of the target; advice on others is passed over.
        patience_s: [s].
    """
    newest: Advice | None = None
    deadline = time.monotonic() + patience_s
    while (remaining := deadline - time.monotonic()) > 0:
        received = told.receive(remaining)
        if received is None or received.message.target_id != target_id:
            continue
        newest = received.message
        if not newest.pending:
            break
    if newest is None:
        return [f"advice: none within {patience_s:g} s; see: w2c status"]
    return lines_of(newest)


def lines_of(advice: Advice) -> list[str]:
    """Return advice as lines: what forbids, what to mind, what is well, what is not known."""
    order = {"veto": 0, "caution": 1, "fine": 2}
    remarks = sorted(advice.remarks, key=lambda remark: order[remark.level])
    lines = [f"{remark.level}: {remark.text}{_numbers(remark)}" for remark in remarks]
    lines += [f"not checked: {item.check}: {item.reason}" for item in advice.unchecked]
    if advice.pending:
        lines.append(f"not checked yet: {', '.join(advice.pending)}")
    return lines


def _numbers(remark: Remark) -> str:
    """Return how strongly a phrase was seen; all other texts say their numbers themselves."""
    if remark.value is None or remark.limit is None or remark.kind != "material":
        return ""
    return f" ({remark.value:.2f}, limit {remark.limit:.2f})"
