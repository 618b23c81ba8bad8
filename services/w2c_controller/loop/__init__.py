"""The loop around the tick: deadlines, times, reports."""
