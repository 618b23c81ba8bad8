#!/usr/bin/env bash
# Makes the environment that the Makefile uses: system libraries, .venv, the llama.cpp wheel, packages.
# Called by make with PYTHON, VENV and EXTRAS; safe to run again.
set -euo pipefail
PYTHON=${PYTHON:-python3.11} VENV=${VENV:-.venv} EXTRAS=${EXTRAS:-all,dev}
LLAMA_WHEEL_VERSION=$(sed -n 's/^llama-cpp-python==//p' constraints.txt)

say() { printf 'setup: %s\n' "$*" >&2; }

# --- room: an installation that runs out of it ends after minutes, in the middle of a package ---------
if [ ! -x "$VENV/bin/w2c" ]; then
    needed_mb=1000
    case ",$EXTRAS," in *,all,* | *,gpu-host,* | *,grounding,* | *,llm,*) needed_mb=4500 ;; esac
    free_mb=$(df -Pm "$(dirname "$VENV")" | awk 'NR == 2 { print $4 }')
    if [ "$free_mb" -lt "$needed_mb" ]; then
        say "$free_mb MB are free beside $VENV, and words2contact[$EXTRAS] needs about $needed_mb MB."
        say "Free some space, or move the checkout to a larger disk."
        exit 2
    fi
fi

# --- system packages: compiler for llama.cpp, headers, OpenMP, off-screen GL for MuJoCo -----------
missing=()
command -v g++ >/dev/null || missing+=(g++)
command -v "$PYTHON" >/dev/null || { command -v python3 >/dev/null && PYTHON=python3; }
"$PYTHON" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || {
    say "Python 3.11 or newer is needed, '$PYTHON' is not. Install it, or say: make PYTHON=/path/to/python"
    exit 2
}
"$PYTHON" -c 'import ensurepip, venv' 2>/dev/null || missing+=(python3-venv)
"$PYTHON" -c 'import sysconfig, pathlib, sys
sys.exit(not (pathlib.Path(sysconfig.get_path("include")) / "Python.h").exists())' || missing+=(python3-dev)
has_library() { ldconfig -p 2>/dev/null | grep -q "$1"; }
has_library libgomp.so.1 || missing+=(libgomp1)
if ! has_library libOSMesa && ! { has_library libEGL.so.1 && [ -e /usr/share/glvnd/egl_vendor.d/50_mesa.json ]; }; then
    missing+=(libegl1 libegl-mesa0 libgl1-mesa-dri libosmesa6)
fi
if [ ${#missing[@]} -gt 0 ]; then
    root=()
    [ "$(id -u)" = 0 ] || root=(sudo -n)
    if command -v apt-get >/dev/null && { [ "$(id -u)" = 0 ] || sudo -n true 2>/dev/null; }; then
        say "installing ${missing[*]}"
        "${root[@]}" apt-get update -qq
        DEBIAN_FRONTEND=noninteractive "${root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
    else
        say "these system packages are missing, and this account may not install them. Run:"
        say "    sudo apt-get update && sudo apt-get install -y ${missing[*]}"
        exit 2
    fi
fi

# --- environment ----------------------------------------------------------------------------------
[ -x "$VENV/bin/python" ] || "$PYTHON" -m venv "$VENV"
pip() { "$VENV/bin/python" -m pip --disable-pip-version-check "$@"; }

# --- llama.cpp: PyPI has no wheel; built once, kept in .wheels/ ---------------------------------------
case ",$EXTRAS," in
*,all,* | *,llm,* | *,gpu-host,*)
    if ! ls .wheels/llama_cpp_python-"$LLAMA_WHEEL_VERSION"-*.whl >/dev/null 2>&1; then
        say "building llama-cpp-python $LLAMA_WHEEL_VERSION (4 minutes on two cores, once)"
        mkdir -p .wheels
        # Its products with AMX end the process (llama.cpp issue 20824): compiled as where there is none,
        # and not taken from pip's cache, where one with them may lie.
        CFLAGS="-U__AMX_INT8__ ${CFLAGS:-}" CXXFLAGS="-U__AMX_INT8__ ${CXXFLAGS:-}" \
            CMAKE_ARGS="-DLLAVA_BUILD=OFF ${CMAKE_ARGS:-}" pip wheel -q --no-cache-dir --no-deps -w .wheels "llama-cpp-python==$LLAMA_WHEEL_VERSION"
    fi
    ;;
esac

# --- torch: without an NVIDIA driver the CPU wheels save gigabytes, where their index answers ---------
index=()
if ! command -v nvidia-smi >/dev/null && [ "$(uname -s)" = Linux ]; then
    cpu_index=https://download.pytorch.org/whl/cpu
    if "$VENV/bin/python" - "$cpu_index" <<'PY'
import sys, urllib.request
try:
    urllib.request.urlopen(sys.argv[1] + "/torch/", timeout=3).close()
except Exception:
    sys.exit(1)
PY
    then index=(--extra-index-url "$cpu_index"); fi
fi

say "installing words2contact[$EXTRAS] into $VENV"
pip install -q --find-links .wheels "${index[@]}" -c constraints.txt -e ".[$EXTRAS]"

# --- the controller's arithmetic, compiled once for this processor; a start need not wait for it ------
case ",$EXTRAS," in
*,all,* | *,controller,* | *,robot-host,*)
    say "compiling the controller's arithmetic (up to two minutes, once)"
    "$VENV/bin/python" -m w2c_controller.warm || say "not compiled now; the first start of the controller will"
    ;;
esac
if [ -x "$VENV/bin/w2c" ]; then say "done"; else say "installation left no $VENV/bin/w2c"; exit 1; fi
