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
    gate = Gate(limit=8)
    inside, most = 0, 0
    start = threading.Barrier(8)

    def visit() -> None:
        nonlocal inside, most
        start.wait()
        for _ in range(50):
            with gate.turn():
                inside += 1
                most = max(most, inside)
                inside -= 1

    threads = [threading.Thread(target=visit) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == 1
    assert gate.waiting == 0
