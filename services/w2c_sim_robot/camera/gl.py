"""Choose how OpenGL is reached without a display.

MuJoCo reads MUJOCO_GL when it is imported; `choose_backend` comes first. Where something else has
imported MuJoCo already, `make_context` still takes the chosen way.
"""

import ctypes
import importlib
import os
import subprocess
import sys
from functools import cache
from typing import Any

from w2c.errors import ConfigError

BACKENDS = {"egl": ("libEGL.so.1",), "osmesa": ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")}
PACKAGES = {"egl": "libegl1 libegl-mesa0 libgl1-mesa-dri", "osmesa": "libosmesa6"}
_PROBE = "import mujoco; context = mujoco.GLContext(8, 8); context.make_current(); context.free()"
_PROBE_TIMEOUT_S = 60.0


def choose_backend() -> str:
    """Set MUJOCO_GL to the first backend that works, egl before osmesa, and return it.

    A choice that the user made in the environment is kept, if it works.

    Raises:
        ConfigError: none works; the message names the packages to install.
    """
    chosen = os.environ.get("MUJOCO_GL", "")
    for backend in [chosen] if chosen else BACKENDS:
        if works(backend):
            os.environ["MUJOCO_GL"] = backend
            return backend
    tried = f"MUJOCO_GL={chosen}" if chosen else " and ".join(BACKENDS)
    raise ConfigError(
        f"no OpenGL without a display: tried {tried}. Install one of them: "
        f"`apt-get install -y {PACKAGES['egl']}` or `apt-get install -y {PACKAGES['osmesa']}`"
    )


def make_context(width: int, height: int) -> Any:
    """Return an OpenGL context (of a class of MuJoCo's, which has no types).

    Raises:
        ConfigError: there is no OpenGL without a display.
    """
    backend = choose_backend()
    return importlib.import_module(f"mujoco.{backend}").GLContext(width, height)


@cache
def works(backend: str) -> bool:
    """Try a backend in a process of its own: a driver that fails may take the process with it."""
    if not any(_can_load(library) for library in BACKENDS.get(backend, ())):
        return False
    environment = {**os.environ, "MUJOCO_GL": backend}
    try:
        done = subprocess.run(
            [sys.executable, "-c", _PROBE],
            env=environment,
            capture_output=True,
            timeout=_PROBE_TIMEOUT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def _can_load(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True
