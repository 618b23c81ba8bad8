"""What this machine has and lacks, in words that say what to do."""

import ctypes.util
import importlib.util
import os
import platform
import resource
import shutil
import sys
from dataclasses import dataclass

from w2c.realtime import ENOUGH_CORES

GL_COMMAND = "apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri libosmesa6"

EXTRAS = {
    "llm": ("llama_cpp", "llguidance"),
    "grounding": ("torch", "transformers", "PIL"),
    "perception": ("pinocchio", "cv2", "zstandard"),
    "controller": ("pinocchio", "daqp", "piqp"),
    "sim-robot": ("mujoco", "cv2"),
    "recorder": ("mcap", "lz4", "zstandard", "cv2", "foxglove_schemas_protobuf"),
    "console": ("starlette", "uvicorn", "websockets"),
}


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at."""

    subject: str
    ok: bool
    text: str
    optional: bool = False


def examine() -> list[Finding]:
    """Return what was found, most basic first."""
    return [
        _python(),
        *(_extra(extra, modules) for extra, modules in EXTRAS.items()),
        _rendering(),
        _compiler(),
        _real_time(),
        _memory_lock(),
        _cores(),
        _disk(),
        _gpu(),
    ]


def _python() -> Finding:
    ok = sys.version_info >= (3, 11)
    return Finding("python", ok, f"{platform.python_version()} (3.11 or newer is needed)")


def _extra(extra: str, modules: tuple[str, ...]) -> Finding:
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    text = "installed"
    if missing:
        text = f"{', '.join(missing)} missing: pip install -c constraints.txt -e '.[{extra}]'"
    return Finding(f"extra {extra}", not missing, text, optional=True)


def _rendering() -> Finding:
    found = [name for name in ("EGL", "OSMesa") if ctypes.util.find_library(name)]
    text = f"{' and '.join(found)}" if found else f"neither EGL nor OSMesa: {GL_COMMAND}"
    return Finding("rendering", bool(found), text)


def _compiler() -> Finding:
    compiler = shutil.which("g++") or shutil.which("clang++")
    text = compiler or "none: needed once, to build llama-cpp-python (apt-get install g++)"
    return Finding("C++ compiler", compiler is not None, text, optional=True)


def _real_time() -> Finding:
    try:
        policy = os.sched_getscheduler(0)
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        os.sched_setscheduler(0, policy, os.sched_param(0))
    except (OSError, AttributeError) as error:
        text = f"not granted ({error}); the loop runs without, and shows its lateness"
        return Finding("SCHED_FIFO", False, text, optional=True)
    cores = len(os.sched_getaffinity(0))
    if cores < ENOUGH_CORES:
        text = (
            f"granted, but with {cores} cores not asked for ({ENOUGH_CORES} are enough): two loops "
            "that go first would starve the models; --real-time on asks all the same"
        )
        return Finding("SCHED_FIFO", True, text)
    return Finding("SCHED_FIFO", True, "granted")


def _memory_lock() -> Finding:
    soft, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    ok = soft == resource.RLIM_INFINITY
    text = (
        "unlimited" if ok else f"{soft // 1024} kB (ulimit -l unlimited lets the controller lock)"
    )
    return Finding("locked memory", ok, text, optional=True)


def _cores() -> Finding:
    count = os.cpu_count() or 1
    return Finding("cores", count >= 2, f"{count} (2 or more)", optional=True)


def _disk() -> Finding:
    free = shutil.disk_usage(".").free
    return Finding("disk", free > 2e9, f"{free / 1e9:.1f} GB free here (2 GB or more)")


def _gpu() -> Finding:
    found = shutil.which("nvidia-smi") is not None
    text = "NVIDIA driver found" if found else "none: models run on the CPU"
    return Finding("GPU", found, text, optional=True)
