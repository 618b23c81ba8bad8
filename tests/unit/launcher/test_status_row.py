"""What `w2c status` says of a process."""

import pytest

from w2c.messages import Health
from w2c_launcher.commands import _print_row


def test_late_periods_are_not_lost_messages(capsys: pytest.CaptureFixture[str]) -> None:
    report = Health(
        stamp_ns=0,
        service="robot",
        instance="0",
        phase="ready",
        pid=7,
        cpu_percent=12.0,
        memory_mb=100.0,
        detail="8.0x real time, runs at 1.00x, 3 late periods",
        counters={"late 20 ms": 2, "command refused: jump": 1, "malformed x": 4},
    )
    _print_row("robot", [report])
    row = capsys.readouterr().out
    assert "dropped or refused 5  late 2  8.0x real time" in row
    _print_row("camera", [])
    assert "camera" in capsys.readouterr().out
