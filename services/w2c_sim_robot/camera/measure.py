"""What a picture costs: processor time and bytes, as `w2c bench camera` reports them."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from w2c.depth import encode_depth
from w2c_sim_robot import talos
from w2c_sim_robot.camera.gl import choose_backend
from w2c_sim_robot.camera.studio import Studio, jpeg
from w2c_sim_robot.model import ready_configuration
from w2c_sim_robot.scenes.scenario_a import scenario_a

NOD = 0.08
"""The head turns by up to this between two pictures, so that none is like the last [rad]"""


@dataclass(frozen=True)
class Cost:
    """Of one picture."""

    case: str
    cpu_ms: float
    """Of all threads of the process: a software renderer draws in threads of its own [ms]"""
    bytes: int
    """On the wire"""


def measure(size: tuple[int, int], count: int, seed: int, *, warm_up: int = 2) -> list[Cost]:
    """Draw and encode scene (a) `count` times a case, the cases in turn, after a warm-up.

    `rgb`: colours as JPEG. `depth`: compressed depth. `rgbd`: both from one pass, what the stream
    sends. `rgbd_pretty`: the same with shadows and antialiasing.
    """
    choose_backend()
    rng = np.random.default_rng(seed)
    studio = Studio(scenario_a(), size=size)
    cases: dict[str, Callable[[], int]] = {
        "rgb": lambda: len(jpeg(studio.shoot(depth=False).rgb)),
        "depth": lambda: len(encode_depth(studio.shoot(colours=False).depth)),
        "rgbd": lambda: _bytes(studio),
        "rgbd_pretty": lambda: _bytes(studio, pretty=True),
    }
    costs = []
    try:
        ready = ready_configuration(studio.model)
        for number in range(-warm_up, count):
            position = ready.copy()
            for joint in talos.HEAD:
                position[studio.model.joint(joint).qposadr[0]] -= rng.uniform(0.0, NOD)
            studio.pose(position)
            for name, draw in cases.items():
                start = time.process_time()
                size_on_wire = draw()
                elapsed = time.process_time() - start
                if number >= 0:
                    costs.append(Cost(name, 1e3 * elapsed, size_on_wire))
    finally:
        studio.close()
    return costs


def _bytes(studio: Studio, *, pretty: bool = False) -> int:
    frame = studio.frame(0, shadows=pretty, antialiasing=pretty)
    return len(frame.jpeg) + len(frame.depth)
