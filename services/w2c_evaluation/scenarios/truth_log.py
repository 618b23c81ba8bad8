"""The log of all that was true in a run, and the way back to each moment of it."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from w2c import topics
from w2c.bus import Bus
from w2c.messages import Array, Truth
from w2c_evaluation.scenarios.eyewitness import Witness


@dataclass(frozen=True)
class Sample:
    """What was true at one moment."""

    stamp_ns: int
    effectors: Array
    """(4, 3) feet, then hands, left before right, in the world [m]"""
    forces: Array
    """(4, 3) what the environment exerts on them, in the world [N]"""
    base: Array
    """(7,) position, quaternion xyzw"""
    body_touched: bool
    """Something other than feet and hands touched something, or the base was very low"""
    contacts: tuple[tuple[str, str, float], ...]
    """The robot's links and what they touch; overlap [m]"""
    objects: dict[str, tuple[float, float, float]]
    """Positions of what can move [m]"""


class TruthLog:
    """Keeps all that the simulator tells, and asks a witness who touches whom at each moment."""

    def __init__(self, bus: Bus, witness: Witness) -> None:
        self._queue = bus.queue(topics.TRUTH, size=20_000)
        self._witness = witness
        self._lock = threading.Lock()
        self._arrived = threading.Condition()
        self._samples: list[Sample] = []
        self._positions: list[Array] = []
        self._stop = threading.Event()
        self._error: Exception | None = None
        self._links = witness.links
        self._thread = threading.Thread(target=self._run, name="truth", daemon=True)

    def __enter__(self) -> "TruthLog":
        """Begin to listen."""
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop listening."""
        self._stop.set()
        self._thread.join(timeout=10.0)

    @property
    def samples(self) -> list[Sample]:
        """Return what was told so far, in order."""
        with self._arrived:
            return list(self._samples)

    @property
    def newest_ns(self) -> int:
        """Return the newest moment [ns]; -1 before the first."""
        with self._arrived:
            return self._samples[-1].stamp_ns if self._samples else -1

    def wait_for(self, stamp_ns: int, patience_s: float) -> bool:
        """Return whether a moment came within so long [s]. Raises what the witness raised."""
        with self._arrived:
            come = self._arrived.wait_for(
                lambda: (
                    self._error is not None
                    or bool(self._samples and self._samples[-1].stamp_ns >= stamp_ns)
                ),
                patience_s,
            )
            if self._error is not None:
                raise self._error
            return come

    @contextmanager
    def moment(self, stamp_ns: int) -> Iterator[Witness]:
        """Give the witness at the moment nearest to a stamp."""
        with self._arrived:
            stamps = np.array([sample.stamp_ns for sample in self._samples])
            position = self._positions[int(np.argmin(np.abs(stamps - stamp_ns)))]
        with self._lock:
            self._witness.pose(position)
            yield self._witness

    def _run(self) -> None:
        while not self._stop.is_set():
            received = self._queue.receive(0.2)
            if received is None:
                continue
            try:
                self._add(received.message)
            except Exception as error:  # handed to who waits, not swallowed
                with self._arrived:
                    self._error = error
                    self._arrived.notify_all()
                return

    def _add(self, truth: Truth) -> None:
        with self._lock:
            self._witness.pose(truth.generalized_position)
            touching = [
                (c.first, c.second, float(c.depth))
                for c in self._witness.contacts()
                if c.first in self._links
            ]
        sample = Sample(
            truth.stamp_ns,
            truth.end_effector_positions,
            truth.contact_forces,
            truth.world_from_base,
            truth.fell,
            tuple(touching),
            dict(truth.scene),
        )
        with self._arrived:
            self._samples.append(sample)
            self._positions.append(truth.generalized_position)
            self._arrived.notify_all()
