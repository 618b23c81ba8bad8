"""`python -m w2c_controller.warm`: compile the loop's arithmetic, so that no start waits for it.

Set-up runs it, and it removes what was compiled from older sources. After a change of the sources
the controller's next start compiles them, before it commands anything.
"""

import sys
import time

from w2c.errors import W2CError
from w2c.library import library
from w2c_controller import compiled


def main() -> int:
    """Rehearse with every robot description that this host has. Returns the exit status."""
    if compiled.numba is None:
        _say("numba is not installed; the controller runs the same code, uncompiled")
        return 0
    from w2c_controller.loop.rehearsal import rehearse

    begin = time.monotonic()
    try:
        rehearse(library("make_description")(lock_step=True))
    except W2CError as error:
        _say(f"no description of a robot here ({error}); compiled at the first start")
        return 0
    compiled.remove_old(compiled.CACHE)
    _say(f"the controller's arithmetic is compiled ({time.monotonic() - begin:.0f} s)")
    return 0


def _say(text: str) -> None:
    sys.stderr.write(f"warm: {text}\n")


if __name__ == "__main__":
    sys.exit(main())
