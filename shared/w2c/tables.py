"""The registry as Markdown tables, for README and reference."""

from w2c import topics

SIMULATED = " (simulation only)"


def streams_table() -> str:
    """Return the table of streams."""
    lines = ["| key (below `w2c/v1/<robot>/`) | message | rate | read by |", "|---|---|---|---|"]
    for row in topics.TOPICS:
        rate = f"{row.rate_hz:g} Hz" if row.rate_hz else "on change"
        readers = ", ".join("all" if name == "*" else name for name in row.readers) or "recorder"
        key = f"{row.kind}/{row.service}/{row.name}"
        only = SIMULATED if row.simulated else ""
        lines.append(f"| `{key}`{only} | {row.message.__name__} | {rate} | {readers} |")
    return "\n".join(lines)


def calls_table() -> str:
    """Return the table of calls."""
    lines = ["| call | request | reply | deadline |", "|---|---|---|---|"]
    for row in topics.METHODS:
        only = SIMULATED if row.simulated else ""
        messages = f"{row.request.__name__} | {row.reply.__name__}"
        lines.append(f"| `{row.service}/{row.name}`{only} | {messages} | {row.timeout_s:g} s |")
    return "\n".join(lines)
