"""Which bounds hold at the optimum, one bound after another: where swaps of many do not end.

A dual active set method (Goldfarb and Idnani, Mathematical Programming 1983) on the factorisation
that is there already. Each set W has multipliers of the right signs, so its point is the optimum
under fewer bounds. A bound r that it exceeds is pressed with a growing multiplier t,

    mu_W = S_WW^-1 (e_W - t S_Wr),      excess = e_r - S_rW S_WW^-1 e_W - t delta

(e: by how much the optimum without bounds exceeds each; delta: what S_WW leaves of S_rr), until it
holds, and joins W, or until a bound of W would pull, and leaves. The cost grows with each bound
that joins, so that no set comes twice: rows that depend on each other, one and the other of which
swaps would try for ever, are told apart.
"""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.solvers.kkt import dot, reduce_positive, solve_positive, substitute_positive
from w2c_controller.solvers.program import Flags, Matrix, Vector
from w2c_controller.solvers.schur import complement, eliminate_new, meet
from w2c_controller.solvers.working_set import collect, slack, value_of

Indices = npt.NDArray[np.intp]

MOST_STEPS: Final = 60
"""A bound that joins takes two, one that leaves takes one."""


@compiled
def step_to_optimum(
    rows: Matrix,
    lower: Vector,
    upper: Vector,
    equalities: int,
    active: Flags,
    order: Indices,
    starts: Indices,
    place: Indices,
    factor: Matrix,
    inverse: Vector,
    reached: Vector,
    columns: Matrix,
    ready: Flags,
    schur: Matrix,
    vectors: Matrix,
    point: Vector,
    working: Indices,
    x: Vector,
) -> int:
    """Go on from any set of bounds to that of the optimum, which x (n,) becomes.

    The arguments are those of `solve_active_set`, after `factorise`; the multipliers of `working`
    are left in `vectors[1]`.

    Returns:
        How many steps that took; -1 where no optimum was found.
    """
    n = x.shape[0]
    sizes, force, least, used, along = vectors[0], vectors[1], vectors[2], vectors[3], vectors[4]
    pressed, side, weight = -1, 0, 0.0
    for step in range(1, MOST_STEPS + 1):
        count = collect(active, working)
        if count < 0 or count + 1 > working.shape[0]:
            return -1
        listed = count
        if pressed >= 0:
            working[count] = pressed
            listed = count + 1
        eliminate_new(factor, starts, place, rows, working, listed, columns, ready)
        complement(columns, working, order, inverse, listed, n, schur, sizes, least)
        for a in range(listed):
            i = working[a]
            above = active[i] > 0 if a < count else side > 0
            force[a] = dot(columns[i], reached) - (upper[i] if above else lower[i])
        if pressed < 0:
            solve_positive(schur, force, least, used, count)
            if drop_worst(active, working, lower, upper, force, sizes, used, count):
                continue
            if not meet(
                factor, starts, place, inverse, reached, columns, working, force, count, point, x
            ):
                return -1
            pressed, side = farthest_beyond(x, rows, lower, upper, equalities, active)
            if pressed < 0:
                return step
            weight = 0.0
            continue
        weight, leaves = press(
            schur, force, along, least, used, active, working, side, weight, count
        )
        if leaves >= 0:
            active[working[leaves]] = 0
        elif weight < math.inf:
            active[pressed] = side
            pressed = -1
        else:
            return -1
    return -1


@compiled
def press(
    schur: Matrix,
    force: Vector,
    along: Vector,
    least: Vector,
    used: Vector,
    active: Flags,
    working: Indices,
    side: int,
    weight: float,
    count: int,
) -> tuple[float, int]:
    """Press the bound that stands behind the others of the set.

    `schur` and `force` are S and e of all of them; the multipliers of the set become
    `force` - t `along`.

    Returns:
        With which multiplier t, at least `weight`, the bound holds, or another would pull; and
        which one of the set that is, or -1. Infinity where neither happens.
    """
    reduce_positive(schur, force, least, used, count, count + 1)
    delta = schur[count, count]
    enough = side * force[count] / delta if delta > least[count] else math.inf
    for a in range(count):
        along[a] = side * schur[a, count]
    substitute_positive(schur, force, used, count)
    substitute_positive(schur, along, used, count)
    leaves = -1
    for a in range(count):
        sign = active[working[a]]
        if sign * along[a] > 0.0 and sign * force[a] < enough * sign * along[a]:
            enough, leaves = max(force[a] / along[a], weight), a
    return enough, leaves


@compiled
def drop_worst(
    active: Flags,
    working: Indices,
    lower: Vector,
    upper: Vector,
    force: Vector,
    sizes: Vector,
    used: Vector,
    count: int,
) -> bool:
    """Take the bound that pulls most from the set, and those that depend on others.

    Returns:
        Whether one pulled.
    """
    worst, most = -1, 0.0
    for a in range(count):
        i = working[a]
        if used[a] == 0.0:
            active[i] = 0
            continue
        pull = -force[a] * sizes[a] * active[i]
        allowed = slack(upper[i] if active[i] > 0 else lower[i])
        if pull > allowed and pull > most:
            worst, most = a, pull
    if worst < 0:
        return False
    active[working[worst]] = 0
    return True


@compiled
def farthest_beyond(
    x: Vector, rows: Matrix, lower: Vector, upper: Vector, equalities: int, active: Flags
) -> tuple[int, int]:
    """Return the bound that x exceeds most for its size, -1 if none, and its side."""
    n = x.shape[0]
    found, side, most = -1, 0, 0.0
    for i in range(n + rows.shape[0]):
        if active[i] != 0 or n <= i < n + equalities:
            continue
        value = value_of(x, rows, i)
        above, below = value - upper[i], lower[i] - value
        if above > slack(upper[i]) and above > most * (1.0 + abs(upper[i])):
            found, side, most = i, 1, above / (1.0 + abs(upper[i]))
        elif below > slack(lower[i]) and below > most * (1.0 + abs(lower[i])):
            found, side, most = i, -1, below / (1.0 + abs(lower[i]))
    return found, side
