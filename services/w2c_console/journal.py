"""The chat: what was said and done, numbered, so that a page that was away can catch up."""

from collections import deque

import numpy as np

from w2c.messages import Advice, AllowedArea, GoalEvent, Remark, Turn
from w2c_console.page import AdviceNews, AreaNews, Entry, GoalEntry, RemarkLine, TurnEntry

ENTRIES_KEPT = 500


class Journal:
    """The last entries."""

    def __init__(self) -> None:
        self._entries: deque[Entry] = deque(maxlen=ENTRIES_KEPT)
        self._count = 0

    def add_turn(self, turn: Turn, time_ms: int) -> None:
        """Append an exchange."""
        self._count += 1
        self._entries.append(turn_entry(turn, time_ms, self._count))

    def add_goal(self, event: GoalEvent, time_ms: int) -> None:
        """Append the progress of a goal."""
        self._count += 1
        entry = GoalEntry(
            id=self._count,
            time_ms=time_ms,
            goal_id=event.goal_id,
            end_effector=event.end_effector.replace("_", " "),
            task=event.task,
            state=event.state,
            reason=event.reason,
            distance=event.distance,
        )
        self._entries.append(entry)

    def after(self, entry_id: int) -> list[Entry]:
        """Return the entries that came after this one."""
        return [entry for entry in self._entries if entry.id > entry_id]


def area_news(area: AllowedArea) -> AreaNews:
    """Return the allowed area of a picture as the page draws it."""
    rows, columns = area.cells.shape
    return AreaNews(
        stamp=str(area.stamp_ns),
        rows=rows,
        columns=columns,
        bits=np.packbits(area.cells == 0, axis=None).tobytes(),
    )


_ORDER = {"veto": 0, "caution": 1, "fine": 2}


def advice_news(advice: Advice) -> AdviceNews:
    """Return advice as the page shows it."""
    remarks = sorted(advice.remarks, key=lambda remark: _ORDER[remark.level])
    return AdviceNews(
        target_id=advice.target_id,
        refusal=advice.refusal,
        remarks=[RemarkLine(r.kind, r.level, r.text, _numbers(r)) for r in remarks],
        unchecked=[f"{item.check}: {item.reason}" for item in advice.unchecked],
        pending=bool(advice.pending),
    )


def _numbers(remark: Remark) -> str:
    """Return how strongly a phrase was seen; all other texts say their numbers themselves."""
    if remark.value is None or remark.limit is None or remark.kind != "material":
        return ""
    return f"{remark.value:.2f}, limit {remark.limit:.2f}"


def turn_entry(turn: Turn, time_ms: int, entry_id: int = 0) -> TurnEntry:
    """Return an exchange as the page shows it."""
    return TurnEntry(
        id=entry_id,
        key=f"{turn.stamp_ns}/{turn.module}/{turn.text}",
        time_ms=time_ms,
        text=turn.text,
        reply=turn.reply,
        ok=turn.ok,
        module=turn.module,
        options=turn.options,
        target_id="" if turn.target is None else turn.target.target_id,
        seconds=turn.seconds,
        steps=turn.steps,
    )
