"""The loop runs the same code without compilation, and to the same commands."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from w2c_controller import compiled, warm

TICKS = """
import json
from w2c_controller.bench.robot import MeantRobot
from w2c_controller.controller import Controller
from w2c_sim_robot.description import make_description

controller = Controller(make_description(lock_step=True))
robot = MeantRobot(controller, seed=0)
for _ in range(4):
    robot.follow(controller.tick(robot.state()).position)
print(json.dumps([controller.retargeting.state.q.tolist(), robot.command.tolist()]))
"""


def _run(uncompiled: str) -> list[np.ndarray]:
    finished = subprocess.run(
        [sys.executable, "-c", TICKS],
        env={**os.environ, "NUMBA_DISABLE_JIT": uncompiled},
        check=True,
        capture_output=True,
        text=True,
        timeout=300,
    )
    return [np.array(values) for values in json.loads(finished.stdout)]


def test_ticks_without_compilation_give_the_same_commands() -> None:
    for compiled_values, plain in zip(_run("0"), _run("1"), strict=True):
        np.testing.assert_allclose(plain, compiled_values, atol=1e-10)


def test_without_numba_functions_stay_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    def function(x: float) -> float:
        return 2.0 * x

    monkeypatch.setattr(compiled, "numba", None)
    assert compiled.compiled(function) is function


def test_warming_says_what_it_did(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(compiled, "numba", None)
    assert warm.main() == 0
    assert "numba is not installed" in capsys.readouterr().err
