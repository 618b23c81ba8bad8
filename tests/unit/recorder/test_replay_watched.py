"""The operator's page and `w2c status` see a replayed session as they saw the session."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec
import pytest

from support.examples import all_examples
from support.sessions import conversation
from support.waiting import wait_until
from w2c import messages as m
from w2c import topics
from w2c.bus import InProcessHub
from w2c.clock import RealClock
from w2c_console.config import ConsoleConfig
from w2c_console.node import ConsoleNode
from w2c_console.stop import BusLine
from w2c_launcher.commands import _collect_health
from w2c_recorder.reading import Recording
from w2c_recorder.replay.options import ReplayOptions
from w2c_recorder.replay.run import play


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A conversation of a whole system: every process reports, the robot and the recorder, too."""
    session = conversation()
    health = all_examples()["Health"]
    for service in topics.SERVICES:
        own = msgspec.structs.replace(health, service=service, instance="0", phase="ready")
        session.add(0.2, topics.HEALTH, own, sender=service)
    session.add(3.4, topics.RECORDER_STATUS, all_examples()["RecorderStatus"])
    table = m.ProcessTable(stamp_ns=0, run_directory="runs/then", processes=[])
    session.add(3.4, topics.PROCESS_TABLE, table)
    return session.write(tmp_path / "session.mcap")


@contextmanager
def watching(hub: InProcessHub) -> Iterator[ConsoleNode]:
    """Run the console of `w2c console --robot replay`."""
    bus = hub.connect("console", robot="replay", instance="watching")
    node = ConsoleNode(ConsoleConfig(robot="replay", port=0), bus, RealClock(), [BusLine(bus)])
    stop = threading.Event()
    node.configure()
    thread = threading.Thread(target=node.run, args=(stop,))
    thread.start()
    try:
        yield node
    finally:
        stop.set()
        thread.join()
        node.close()


def test_the_page_shows_what_it_showed(file: Path) -> None:
    hub = InProcessHub()
    bus = hub.connect("replay", robot="replay")
    options = ReplayOptions(speed=20.0, loop=True)
    stop = threading.Event()
    operator = hub.connect("operator", robot="replay")

    def replay() -> None:
        play(Recording(file), options, bus, RealClock(), stop, settle_s=0.0)

    with watching(hub) as node:
        player = threading.Thread(target=replay)
        player.start()
        try:

            def everything_is_shown() -> bool:
                panel, scene = node.model.panel(RealClock().now_ns()), node.model.scene(live=False)
                ready = {row.name for row in panel.processes if row.phase == "ready"}
                return (
                    scene.frame is not None
                    and None not in (panel.robot, panel.controller, panel.recorder)
                    and ready >= set(topics.SERVICES)
                    and len(node.model.entries(0)) >= 5
                )

            wait_until(everything_is_shown)
            reports = _collect_health(operator, 0.5)
        finally:
            stop.set()
            player.join()

    assert {report.service for report in reports} == set(topics.SERVICES)
    assert {report.phase for report in reports} == {"ready"}
