"""One at a time, few wait, the rest are refused."""

import threading

import pytest

from w2c.errors import RefusedError
from w2c_grounding.gate import Gate


def test_a_full_gate_refuses_with_its_limit_and_opens_again() -> None:
    gate = Gate(limit=0)
    with gate.turn():
        with pytest.raises(RefusedError, match="limit 0"), gate.turn():
            pass
        assert gate.waiting == 0
    with gate.turn():
        assert gate.waiting == 0


def test_an_error_inside_gives_the_turn_back() -> None:
    gate = Gate(limit=0)
    with pytest.raises(ValueError, match="inside"), gate.turn():
        raise ValueError("inside")
    with gate.turn():
        pass


def test_never_two_inside_at_once() -> None:
    gate = Gate(limit=1)
    meeting = threading.Barrier(2)
    met: list[bool] = []

    def visit() -> None:
        with gate.turn():
            try:
                meeting.wait(timeout=0.2)  # passes only if the other is inside too
                met.append(True)
            except threading.BrokenBarrierError:
                met.append(False)
                meeting.reset()

    threads = [threading.Thread(target=visit) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert met == [False, False]
    assert gate.waiting == 0
