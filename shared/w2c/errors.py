"""Every error this project raises.

    W2CError
    ├── ConfigError          a flag, a file or an environment is wrong; exit status 2
    │   └── MissingExtraError    an optional dependency of a service is not installed
    ├── MessageError         bytes on the bus are not a valid message
    ├── GeometryError        a pose, pixel or vector outside its domain
    ├── BusError             the transport
    │   ├── ConnectionFailedError    no router, no robot, a port in use
    │   └── CallError                a call to another service did not give a result
    │       ├── UnavailableError         nobody serves it, or its process died while serving
    │       ├── DeadlineError            no reply in time
    │       ├── RefusedError             the service understood, and said no, with a reason
    │       │   └── NotNowError              the same may be granted a little later
    │       └── RemoteError              the service failed
    ├── ModelError           a language or vision model cannot be loaded, or answered outside its
    schema
    ├── ControlError         the controller
    │   ├── GoalRefusedError         a goal is malformed, unsafe or out of order
    │   └── SolverError              a QP has no solution; carries the problem
    ├── RecordingError       a recording cannot be written or read
    └── ProcessError         a process did not start, or keeps dying

A message gives the value, the limit, and what to do next.
"""


class W2CError(Exception):
    """Base of all errors of this project."""

    code = "error"
    retryable = False


class ConfigError(W2CError):
    """A flag, a configuration file or the machine is wrong. Exit status 2."""

    code = "config"


class MissingExtraError(ConfigError):
    """A service was started without its optional dependencies."""

    def __init__(self, module: str, extra: str) -> None:
        super().__init__(
            f"'{module}' is not installed; this command needs it. "
            f"Run: pip install -c constraints.txt -e '.[{extra}]'"
        )
        self.module = module
        self.extra = extra


class MessageError(W2CError):
    """Bytes on the bus are not a valid message."""

    code = "message"


class GeometryError(W2CError):
    """A pose, a pixel or a vector is outside its domain."""

    code = "geometry"


class BusError(W2CError):
    """The transport failed."""

    code = "bus"


class ConnectionFailedError(BusError):
    """No router or robot answers, or an endpoint cannot be opened."""

    code = "connection"
    retryable = True


class CallError(BusError):
    """A call to another service did not give a result."""

    code = "call"


class UnavailableError(CallError):
    """Nobody serves the method, or the process died while it served the call."""

    code = "unavailable"
    retryable = True


class DeadlineError(CallError):
    """No reply came before the deadline."""

    code = "deadline"
    retryable = True


class RefusedError(CallError):
    """The service understood the request and refuses it, with a reason the operator can read."""

    code = "refused"


class NotNowError(RefusedError):
    """Refused for the moment: the same request may be granted a little later.

    Over the bus it is a `RefusedError`.
    """

    retryable = True


class RemoteError(CallError):
    """The service failed while it served the call."""

    code = "remote"


class ModelError(W2CError):
    """A model cannot be loaded, or its answer does not fit the schema it was given."""

    code = "model"


class ControlError(W2CError):
    """The controller cannot do what was asked."""

    code = "control"


class GoalRefusedError(ControlError):
    """A goal is malformed, unsafe, or comes at the wrong time. Nothing moved."""

    code = "refused"


class SolverError(ControlError):
    """A quadratic program has no solution."""

    code = "solver"


class RecordingError(W2CError):
    """A recording cannot be written or read."""

    code = "recording"


class ProcessError(W2CError):
    """A process did not start, or keeps dying."""

    code = "process"


def error_codes() -> dict[str, type[W2CError]]:
    """Return code -> class for the errors that cross the bus in a reply."""
    return {
        cls.code: cls
        for cls in (CallError, UnavailableError, DeadlineError, RefusedError, RemoteError)
    }
