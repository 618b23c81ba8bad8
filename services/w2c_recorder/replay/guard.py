"""Nothing recorded may reach a robot that lives, and nothing said may come from two."""

import time

from w2c import topics
from w2c.bus import StandIn
from w2c.errors import RefusedError
from w2c_recorder.mcap_file import head_of
from w2c_recorder.replay.namespace import Namespace

LIVING = ("robot", "controller")
"""Who must not be in the namespace of a replay: recorded states and commands would move it"""
REPLAY = "replay"
"""Name of this process on the bus"""


class Guard:
    """Looks who else is in the namespace, before and during a replay."""

    def __init__(self, bus: StandIn, namespace: Namespace, settle_s: float = 1.0) -> None:
        """Prepare.

        Args:
            bus: of the replay.
            namespace: whose boot ids are the replay's own.
            settle_s: how long to wait for the signs of life of others [s].
        """
        self._bus = bus
        self._namespace = namespace
        self._settle_s = settle_s
        self._health = [
            bus.raw_queue(topics.HEALTH.key(bus.robot, service), 100) for service in LIVING
        ]

    def check_before(self) -> None:
        """Raise RefusedError where a robot, a controller or another replay is there."""
        deadline = time.monotonic() + self._settle_s
        while True:
            for service, instance in self._bus.alive():
                if service in LIVING:
                    self._refuse(service)
                if service == REPLAY and instance != self._bus.instance:
                    raise RefusedError(
                        f"another replay plays as '{self._bus.robot}'; end it, or choose another "
                        "name with --as"
                    )
            if time.monotonic() >= deadline:
                return
            time.sleep(0.05)

    def check(self) -> bool:
        """Return True. Raises RefusedError where a robot or a controller came meanwhile.

        Their signs of life cannot be told from those that the replay gives in their names; what
        they say of themselves can.
        """
        for service, reports in zip(LIVING, self._health, strict=True):
            while (raw := reports.receive(0.0)) is not None:
                head = head_of(raw.payload)
                if head is not None and not self._namespace.is_own(head.boot_id):
                    self._refuse(service)
        return True

    def _refuse(self, service: str) -> None:
        raise RefusedError(
            f"a {service} lives as '{self._bus.robot}': a recording is never played into a live "
            "robot. Choose another name with --as"
        )
