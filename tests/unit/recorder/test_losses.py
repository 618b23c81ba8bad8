"""Losses are counted once, per key and boot, and taken back when a message was only late."""

from hypothesis import given
from hypothesis import strategies as st

from w2c_recorder.losses import MAX_MISSING, LossCounter


def observed(sequences: list[int], key: str = "k", boot: str = "b") -> LossCounter:
    counter = LossCounter()
    for sequence in sequences:
        counter.observe(key, boot, sequence)
    return counter


def test_an_unbroken_stream_has_no_loss() -> None:
    assert observed(list(range(100))).lost() == {}


def test_a_gap_counts_the_numbers_that_are_missing() -> None:
    assert observed([0, 1, 5, 6, 8]).lost() == {"k": 4}


def test_observe_returns_what_is_newly_missing() -> None:
    counter = observed([0])

    assert counter.observe("k", "b", 3) == 2
    assert counter.observe("k", "b", 4) == 0


def test_a_late_start_is_no_loss() -> None:
    assert observed([500, 501]).lost() == {}


def test_a_restart_of_the_sender_is_no_loss() -> None:
    counter = observed([7, 8, 9], boot="first")
    counter.observe("k", "second", 0)
    counter.observe("k", "second", 1)

    assert counter.lost() == {}


def test_two_replicas_on_one_key_add_up() -> None:
    counter = LossCounter()
    for boot in ("one", "two"):
        counter.observe("k", boot, 0)
        counter.observe("k", boot, 2)

    assert counter.lost() == {"k": 2}


def test_a_message_that_was_overtaken_is_not_lost() -> None:
    counter = observed([0, 2, 1, 3])

    assert counter.lost() == {}
    assert counter.repeated == 0


def test_a_repetition_is_counted_apart() -> None:
    counter = observed([0, 1, 1, 2])

    assert counter.lost() == {}
    assert counter.repeated == 1


def test_a_huge_gap_takes_bounded_memory_and_is_counted_in_full() -> None:
    counter = observed([0, 10**9])

    assert counter.lost() == {"k": 10**9 - 1}


def test_many_gaps_beyond_the_memory_are_all_counted() -> None:
    every_third = list(range(0, 6 * MAX_MISSING, 3))

    assert observed(every_third).lost() == {"k": 2 * (len(every_third) - 1)}


@given(st.sets(st.integers(1, 200)), st.randoms(use_true_random=False))
def test_loss_is_what_never_came_whatever_the_order(missing: set[int], random) -> None:  # type: ignore[no-untyped-def]
    """Message 0 comes first and 201 last; between them any subset, in any order."""
    between = [sequence for sequence in range(1, 201) if sequence not in missing]
    random.shuffle(between)
    expected = {"k": len(missing)} if missing else {}

    assert observed([0, *between, 201]).lost() == expected
