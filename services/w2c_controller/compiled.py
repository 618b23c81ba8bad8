"""Compilation of the arithmetic of the loop: numba where it is installed, plain Python where not.

A compiled function fills arrays that exist already: it does not allocate, and it runs the same
lines either way. Compiled code is kept on disk; `deploy/setup.sh` warms it.

numba compiles a function anew when its own file changes, and not when a function that it calls
does, which may stand in another file: a robot would run old arithmetic after an update. So the code
of each state of the sources has a directory of its own.
"""

import hashlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

numba: Any
try:
    import numba
except ImportError:
    numba = None

PREFIX = "compiled-"
"""Of the names of these directories"""


def source_digest(package: Path) -> str:
    """Return what names the state of all modules in a package that have compiled functions.

    What those take from other modules are types, and indices of end effectors, which never change.
    """
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        source = path.read_bytes()
        if b"@compiled" in source:
            digest.update(str(path.relative_to(package)).encode() + b"\0" + source + b"\0")
    return digest.hexdigest()[:16]


def cache_root(package: Path) -> Path:
    """Return where these directories are: beside the source where one may write, or the user's."""
    beside = package / "__pycache__"
    if os.access(beside if beside.exists() else package, os.W_OK):
        return beside
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "words2contact"


def remove_old(current: Path) -> list[Path]:
    """Remove the compiled code of other states of the sources. Returns what was removed.

    Args:
        current: Where that of this state is; that of others lies beside it.
    """
    old = [path for path in current.parent.glob(f"{PREFIX}*") if path != current]
    for path in old:
        shutil.rmtree(path, ignore_errors=True)
    return old


_PACKAGE = Path(__file__).parent
CACHE = cache_root(_PACKAGE) / f"{PREFIX}{source_digest(_PACKAGE)}"
"""Where compiled code is kept, if NUMBA_CACHE_DIR does not say"""

P = ParamSpec("P")
R = TypeVar("R")


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function of arrays and numbers; division by zero gives infinity, as in C.

    Sums may be reordered and fused, so that they use the vector unit; NaN and infinity stay
    themselves.
    """
    if numba is None:
        return function
    if "NUMBA_CACHE_DIR" not in os.environ:
        # For each function: numba reads its settings anew when a NUMBA_* variable has changed.
        numba.config.CACHE_DIR = str(CACHE)
    result: Callable[P, R] = numba.njit(
        cache=True, error_model="numpy", fastmath={"reassoc", "contract"}
    )(function)
    return result
