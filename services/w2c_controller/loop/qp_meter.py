"""How the quadratic programs of the loop fare."""

from w2c.messages import QpStatistics
from w2c_controller.solvers import FallbackSolver


class QpMeter:
    """Watches the counters of one solver from tick to tick."""

    def __init__(self, solver: FallbackSolver) -> None:
        self._solver = solver
        self._iterations = 0
        self._most = 0
        self._told = (0, 0)

    def step(self) -> None:
        """Look once a tick. For the loop."""
        iterations = self._solver.iterations
        used = iterations - self._iterations
        self._iterations = iterations
        self._most = max(self._most, used)

    def report(self) -> QpStatistics:
        """Return the statistics; means and maxima are of the time since the last report."""
        solver, (solves, iterations) = self._solver, self._told
        solved = solver.solves - solves
        mean = (solver.iterations - iterations) / solved if solved else 0.0
        self._told = (solver.solves, solver.iterations)
        most, self._most = self._most, 0
        return QpStatistics(
            solved=solver.solves - solver.failures,
            fallbacks=solver.fallbacks,
            failures=solver.failures,
            iterations_mean=mean,
            iterations_max=most,
            active_rows=solver.active_rows,
        )
