"""Every event of the safety table has a test that exists, and every cause is in the table."""

import re
import typing

import pytest

from support.documents import ROOT
from w2c.messages.control import SafetyCause

TABLE = ROOT / "docs" / "explanation" / "safety.md"
TEST = re.compile(r"`(tests/[\w/]+\.py)::(test_\w+)`")
ROWS = [
    line
    for line in TABLE.read_text().splitlines()
    if line.startswith("|") and not line.startswith(("| event", "|---"))
]
WORDS = {
    "sensor_not_finite": "NaN",
    "sensor_frozen": "frozen sensors",
    "state_stale": "no state",
    "state_out_of_order": "out of order",
    "position_limit": "joint beyond its limits",
    "velocity_limit": "joint too fast",
    "torque_limit": "joint torque",
    "not_following": "does not follow",
    "command_jump": "command jump",
    "command_not_finite": "command not finite",
    "command_not_taken": "takes no command",
    "qp_failed": "quadratic program",
    "hand_overload": "overload",
    "contact_lost": "lost contact",
    "contact_slips": "slipping contact",
    "contact_unexpected": "unexpected contact",
    "stopped": "operator stop",
    "no_snapshot": "no snapshot that fits",
}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.split("|")[1].strip())
def test_each_row_names_a_test_that_exists(row: str) -> None:
    found = TEST.search(row)
    assert found is not None, "no test"
    path, name = found.groups()
    assert re.search(rf"^def {name}\(", (ROOT / path).read_text(), re.MULTILINE), f"no {name}"
    assert row.count("|") == 6, "five columns"


@pytest.mark.parametrize("cause", typing.get_args(SafetyCause))
def test_each_cause_has_a_row(cause: str) -> None:
    assert any(WORDS[cause] in row.split("|")[1] for row in ROWS)
