"""Strictly convex quadratic programs, and three ways to solve them behind one interface."""

from w2c_controller.solvers.active_set import ActiveSetSolver
from w2c_controller.solvers.daqp_solver import DaqpSolver
from w2c_controller.solvers.fallback import FallbackSolver
from w2c_controller.solvers.piqp_solver import PiqpSolver
from w2c_controller.solvers.program import UNBOUNDED, Program, Solver, UnsolvedError

__all__ = [
    "UNBOUNDED",
    "ActiveSetSolver",
    "DaqpSolver",
    "FallbackSolver",
    "PiqpSolver",
    "Program",
    "Solver",
    "UnsolvedError",
]
