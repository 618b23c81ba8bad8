"""daqp: a dual active set method, exact, fast while few rows are active.

Arnström, Bemporad and Axehill, "A Dual Active-Set Solver for Embedded Quadratic Programming Using
Recursive LDL' Updates", IEEE TAC 2022.
"""

import daqp
import numpy as np
import numpy.typing as npt

from w2c_controller.solvers.program import Program, UnsolvedError, Vector

_EQUALITY = 5
"""daqp's flag of a constraint that holds with equality."""


class DaqpSolver:
    """Solves every program from nothing; keeps no state between two programs but their flags."""

    def __init__(self) -> None:
        self._senses: dict[tuple[int, int, int], npt.NDArray[np.int32]] = {}

    def solve(self, program: Program) -> Vector:
        """Return the optimum (n,). Raises UnsolvedError."""
        x, _, flag, told = daqp.solve(
            program.full_hessian(),
            program.gradient,
            program.rows,
            program.upper,
            program.lower,
            self._sense(program),
            primal_tol=1e-8,
            iter_limit=500,
        )
        if flag != 1 or not np.isfinite(x).all():
            raise UnsolvedError(
                f"daqp ends with flag {flag} (1 = optimal, -1 = infeasible)", program
            )
        np.sign(told["lam"], out=program.active, casting="unsafe")
        program.active[program.size : program.size + program.equalities] = 0
        return np.asarray(x)

    def _sense(self, program: Program) -> npt.NDArray[np.int32]:
        """Return the flags of the constraints; daqp writes into them, so they are a fresh copy."""
        key = (program.size, program.rows.shape[0], program.equalities)
        if key not in self._senses:
            sense = np.zeros(program.lower.size, dtype=np.int32)
            sense[program.size : program.size + program.equalities] = _EQUALITY
            self._senses[key] = sense
        return self._senses[key].copy()
