"""piqp: a proximal interior point method, robust to degenerate rows.

Schwan, Jiang, Kuhn and Jones, "PIQP: A Proximal Interior-Point Quadratic Programming Solver", CDC
2023.
"""

from typing import Any

import numpy as np
import piqp

from w2c_controller.solvers.program import Program, UnsolvedError, Vector


class PiqpSolver:
    """Solves every program from nothing: the last resort, and the reference in tests."""

    def solve(self, program: Program) -> Vector:
        """Return the optimum (n,). Raises UnsolvedError."""
        n, k = program.size, program.equalities
        solver = piqp.DenseSolver()
        solver.settings.eps_abs = 1e-8
        solver.settings.eps_rel = 1e-9
        arguments: list[Any] = [
            np.asfortranarray(program.full_hessian()),
            program.gradient,
            np.asfortranarray(program.rows[:k]),
            program.upper[n : n + k],
            np.asfortranarray(program.rows[k:]),
            program.lower[n + k :],
            program.upper[n + k :],
            program.lower[:n],
            program.upper[:n],
        ]
        solver.setup(*arguments)
        status = solver.solve()
        if status != piqp.PIQP_SOLVED:
            raise UnsolvedError(f"piqp ends with {status}", program)
        return np.array(solver.result.x)
