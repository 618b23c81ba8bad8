"""The bus on Zenoh 1.10.

Everyone is a client of a router, but for the robot driver: a peer that listens for the controller
and dials
the router, so that the router's death leaves robot and controller talking. Scouting, gossip and
shared memory
are off; everyone dials one way only, with the same lease.
"""

import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import zenoh

from w2c import topics
from w2c.bus.base import BusBase
from w2c.bus.interface import RawReceived
from w2c.bus.latest_ring import LatestRing
from w2c.bus.zenoh_config import client_config, hub_config
from w2c.config import ServiceConfig
from w2c.errors import ConnectionFailedError, RemoteError, UnavailableError
from w2c.messages import Message
from w2c.topics import Method, Topic

M = TypeVar("M", bound=Message)

PRIORITIES = {
    topics.Priority.REAL_TIME: zenoh.Priority.REAL_TIME,
    topics.Priority.INTERACTIVE: zenoh.Priority.INTERACTIVE_HIGH,
    topics.Priority.DATA: zenoh.Priority.DATA,
    topics.Priority.DATA_LOW: zenoh.Priority.DATA_LOW,
}
NOT_DELIVERED_S = 0.05
"""An empty answer that comes sooner means that the call reached nobody yet: safe to ask again. A
later one means it, too, if the process stays: then the machine is slow [s]"""
GOING_PATIENCE_S = 0.5
"""How long after its answer fails to come a process that died may still be seen [s]"""
SHORTEST_RETRY_S = 0.05
"""A last try with less time would tell of the deadline, not of what is missing [s]"""
LIVELINESS_PATIENCE_S = 1.5
"""How long a call waits for a process of the service to be seen at all [s]"""
START_PATIENCE_S = 10.0
"""... and for one that is seen to take calls: it may still be built, on a machine with much to do
[s]"""


def connect(config: ServiceConfig, service: str, endpoints: list[str]) -> "ZenohBus":
    """Return the bus of a client of a router, or of the robot. Raises ConnectionFailedError."""
    try:
        session = zenoh.open(client_config(endpoints, config.connect_timeout))
    except zenoh.ZError as error:
        raise ConnectionFailedError(
            f"no answer at {', '.join(endpoints)} within {config.connect_timeout:g} s. "
            "Is the system running? Start it with: w2c up"
        ) from error
    return ZenohBus(session, config.robot, service, config.instance)


def connect_hub(config: ServiceConfig, service: str) -> "ZenohBus":
    """Return the bus of the robot driver: listens at `robot_endpoint`, dials `router`."""
    try:
        session = zenoh.open(hub_config(config.robot_endpoint, config.router))
    except zenoh.ZError as error:
        raise ConnectionFailedError(
            f"cannot listen at {config.robot_endpoint}: {error}. "
            "Is another robot driver running? Choose another --robot-endpoint"
        ) from error
    return ZenohBus(session, config.robot, service, config.instance)


class ZenohBus(BusBase):
    """See `w2c.bus.interface.Bus`. Use it in a `with`: an unclosed session hangs the exit."""

    def __init__(self, session: zenoh.Session, robot: str, service: str, instance: str) -> None:
        super().__init__(robot, service, instance)
        self._session = session
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._raw_publishers: dict[str, zenoh.Publisher] = {}
        self._stand_ins: dict[tuple[str, str], Any] = {}
        self._publisher_lock = threading.Lock()
        self._declared: list[Any] = []
        self._pools: list[ThreadPoolExecutor] = []
        self._alive: dict[str, tuple[str, str]] = {}
        self._outstanding: dict[str, int] = {}
        self._alive_changed = threading.Condition()
        self._closed = False
        self._declared.append(
            session.liveliness().declare_subscriber(
                topics.liveliness_key(robot),
                zenoh.handlers.Callback(self._on_liveliness, indirect=False),
                history=True,
            )
        )
        self._declared.append(
            session.liveliness().declare_token(topics.liveliness_key(robot, service, instance))
        )

    @property
    def links(self) -> list[str]:
        """Return the ids of the sessions this one is linked to."""
        info = self._session.info
        return [str(zid) for zid in [*info.routers_zid(), *info.peers_zid()]]

    def latest(self, topic: Topic[M]) -> LatestRing[M]:
        """Subscribe to the newest value."""
        subscriber = self._session.declare_subscriber(
            topic.key(self.robot), zenoh.handlers.RingChannel(1)
        )
        self._declared.append(subscriber)
        return LatestRing(subscriber, lambda raw: self._decode(topic.message, topic.max_bytes, raw))

    def alive(self) -> list[tuple[str, str]]:
        """Return (service, instance) of every process whose liveliness token is seen."""
        with self._alive_changed:
            return sorted(self._alive.values())

    def appear(self, service: str, instance: str) -> None:
        """Let a process be seen."""
        if (service, instance) not in self._stand_ins:
            key = topics.liveliness_key(self.robot, service, instance)
            self._stand_ins[service, instance] = self._session.liveliness().declare_token(key)

    def disappear(self, service: str, instance: str) -> None:
        """Let it be seen no more."""
        token = self._stand_ins.pop((service, instance), None)
        if token is not None:
            token.undeclare()

    def close(self) -> None:
        """Stop serving, undeclare everything. Idempotent."""
        if self._closed:
            return
        self._closed = True
        for pool in self._pools:
            pool.shutdown(wait=False, cancel_futures=True)
        self._session.close()  # type: ignore[no-untyped-call]

    def _on_liveliness(self, sample: zenoh.Sample) -> None:
        key = str(sample.key_expr)
        service, instance = key.split("/")[-2:]
        with self._alive_changed:
            if sample.kind == zenoh.SampleKind.PUT:
                self._alive[key] = (service, instance)
            else:
                self._alive.pop(key, None)
            self._alive_changed.notify_all()

    def _publisher(self, topic: Topic[Any], key: str) -> zenoh.Publisher:
        known = self._publishers.get(key)
        if known is not None:
            return known
        with self._publisher_lock:
            publisher = self._publishers.get(key)
            if publisher is None:
                drops = topic.drops and not (topic.lock_step and self.lock_step)
                publisher = self._session.declare_publisher(
                    key,
                    encoding=f"application/msgpack;w2c.{topic.message.__name__}",
                    congestion_control=(
                        zenoh.CongestionControl.DROP if drops else zenoh.CongestionControl.BLOCK
                    ),
                    priority=PRIORITIES[topic.priority],
                    # `express` loses samples under load (measured), and gains nothing.
                    express=False,
                )
                self._publishers[key] = publisher
            return publisher

    def _send(self, topic: Topic[Any], key: str, payload: bytes) -> None:
        if self._closed:
            self.count(f"closed {key}")
            return
        self._publisher(topic, key).put(payload)

    def _send_raw(self, key: str, payload: bytes, priority: topics.Priority) -> None:
        publisher = self._raw_publishers.get(key)
        if publisher is None:
            publisher = self._session.declare_publisher(
                key,
                encoding="application/msgpack",
                congestion_control=zenoh.CongestionControl.BLOCK,
                priority=PRIORITIES[priority],
                express=False,
            )
            self._raw_publishers[key] = publisher
        publisher.put(payload)

    def use_lock_step(self) -> None:
        """From now on block, instead of drop, on the links that lock step must not lose."""
        super().use_lock_step()
        with self._publisher_lock:
            for topic in topics.TOPICS:
                publisher = self._publishers.pop(topic.key(self.robot, self.service), None)
                if publisher is not None and topic.lock_step:
                    publisher.undeclare()  # type: ignore[no-untyped-call]

    def _subscribe(self, key_expression: str, deliver: Callable[[RawReceived], None]) -> None:
        def receive(sample: zenoh.Sample) -> None:
            deliver(
                RawReceived(str(sample.key_expr), sample.payload.to_bytes(), time.monotonic_ns())
            )

        # Direct: the mailbox never blocks Zenoh's receiving thread, and needs no thread of its own.
        self._declared.append(
            self._session.declare_subscriber(
                key_expression, zenoh.handlers.Callback(receive, indirect=False)
            )
        )

    def _serve(
        self, key: str, handle: Callable[[RawReceived], tuple[bool, bytes]], workers: int
    ) -> None:
        name = key.rsplit("/", 1)[-1]
        pool = ThreadPoolExecutor(workers, thread_name_prefix=f"serve-{name}")

        def answer(query: zenoh.Query) -> None:
            with query:  # a query that is not dropped keeps its caller waiting until the deadline
                payload = query.payload.to_bytes() if query.payload is not None else b""
                done, reply = handle(RawReceived(key, payload, time.monotonic_ns()))
                if done:
                    query.reply(key, reply)
                else:
                    query.reply_err(reply)

        def enqueue(query: zenoh.Query) -> None:
            if not self._closed:
                pool.submit(answer, query)

        self._pools.append(pool)
        self._declared.append(
            self._session.declare_queryable(key, zenoh.handlers.Callback(enqueue, indirect=False))
        )

    def _instance_of(self, service: str, patience_s: float) -> str | None:
        """Return the live replica with the fewest calls of ours; wait a little for the first."""

        def candidates() -> list[str]:
            return [instance for name, instance in self._alive.values() if name == service]

        with self._alive_changed:
            self._alive_changed.wait_for(lambda: bool(candidates()), patience_s)
            found = candidates()
            return min(
                found, key=lambda i: (self._outstanding.get(f"{service}/{i}", 0), i), default=None
            )

    def _is_alive(self, service: str, instance: str) -> bool:
        """Tell whether a process is still seen."""
        return (service, instance) in self.alive()

    def _ask(
        self, method: Method[Any, Any], payload: bytes, timeout_s: float, instance: str | None
    ) -> tuple[str, RawReceived]:
        deadline = time.monotonic() + timeout_s
        patience = min(timeout_s, LIVELINESS_PATIENCE_S)
        instance = instance or self._instance_of(method.service, patience)
        if instance is None:
            raise self._unavailable(method)
        slot = f"{method.service}/{instance}"
        with self._alive_changed:
            self._outstanding[slot] = self._outstanding.get(slot, 0) + 1
        try:
            tried = False
            while True:
                remaining = deadline - time.monotonic()
                if remaining <= (SHORTEST_RETRY_S if tried else 0.0):
                    raise self._unavailable(method)  # no attempt reached it
                started = time.monotonic()
                raw = self._ask_once(method, instance, payload, remaining)
                if raw is not None:
                    return instance, raw
                tried = True
                slow = time.monotonic() - started > NOT_DELIVERED_S
                if slow and self._is_going(method.service, instance):
                    raise UnavailableError(
                        f"{method.service}/{method.name}: the process died while it served the call"
                    )
                waited = time.monotonic() - (deadline - timeout_s)
                if waited > min(timeout_s, START_PATIENCE_S) or not self._is_alive(
                    method.service, instance
                ):
                    raise self._unavailable(method)
                time.sleep(0.02)
        finally:
            with self._alive_changed:
                self._outstanding[slot] -= 1

    def _is_going(self, service: str, instance: str) -> bool:
        """Tell whether a process disappears now. One that stays was not reached by the call."""
        with self._alive_changed:
            return self._alive_changed.wait_for(
                lambda: (service, instance) not in self._alive.values(), GOING_PATIENCE_S
            )

    def _ask_once(
        self, method: Method[Any, Any], instance: str, payload: bytes, timeout_s: float
    ) -> RawReceived | None:
        """Return the reply; None where nobody answered, which is no success."""
        key = method.key(self.robot, instance)
        replies = list(
            self._session.get(
                key,
                payload=payload,
                timeout=timeout_s,
                consolidation=zenoh.ConsolidationMode.NONE,
                congestion_control=zenoh.CongestionControl.BLOCK,
            )
        )
        if len(replies) > 1:
            raise RemoteError(
                f"{len(replies)} processes answered {key}; give each replica its own --instance"
            )
        for reply in replies:
            if reply.err is not None:
                self._raise_error_reply(method, reply.err.payload.to_bytes())
            elif reply.ok is not None:
                return RawReceived(key, reply.ok.payload.to_bytes(), time.monotonic_ns())
        return None
