"""Compilation of the arithmetic of the loop: numba where it is installed, plain Python where not.

A compiled function fills arrays that exist already: it does not allocate, and it runs the same
lines either way. Compiled code is kept on disk beside its source; `deploy/setup.sh` warms it.
"""

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

numba: Any
try:
    import numba
except ImportError:
    numba = None

P = ParamSpec("P")
R = TypeVar("R")


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function of arrays and numbers; division by zero gives infinity, as in C.

    Sums may be reordered and fused, so that they use the vector unit; NaN and infinity stay
    themselves.
    """
    if numba is None:
        return function
    result: Callable[P, R] = numba.njit(
        cache=True, error_model="numpy", fastmath={"reassoc", "contract"}
    )(function)
    return result
