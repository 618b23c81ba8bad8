"""`w2c router`: the broker between the processes, in pure Python."""

import sys
import threading

import msgspec
import zenoh

from w2c.bus.zenoh_config import base_config
from w2c.config import fail, parse
from w2c.errors import ConfigError, ConnectionFailedError
from w2c.service import stop_on_signals


class RouterConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Options of the router."""

    listen: str = "tcp/127.0.0.1:7447"
    """Endpoint to listen at. A non-loopback address needs TLS and access control: see deploy/."""
    zenoh_config: str = ""
    """A Zenoh configuration file (JSON5): TLS, users, access control. It names the endpoints, too:
    `--listen` is then not used."""


def open_router(config: RouterConfig) -> zenoh.Session:
    """Return the router's session. Raises ConnectionFailedError for a port in use."""
    if config.zenoh_config:
        try:
            settings = zenoh.Config.from_file(config.zenoh_config)
        except zenoh.ZError as error:
            raise ConfigError(f"{config.zenoh_config}: {error}") from error
    else:
        settings = base_config("router")
        settings.insert_json5("listen/endpoints", f'["{config.listen}"]')
    try:
        return zenoh.open(settings)
    except zenoh.ZError as error:
        raise ConnectionFailedError(
            f"cannot listen at {config.listen}: {error}. "
            "Is another router running? Choose another --listen, or stop it with: w2c down"
        ) from error


def run(config: RouterConfig, stop: threading.Event) -> None:
    """Route until `stop` is set."""
    with open_router(config):
        sys.stderr.write(f"router listens at {config.listen}\n")
        stop.wait()


def main(arguments: list[str] | None = None) -> int:
    """Run the router. Exit status: 0 stopped, 1 failed, 2 usage."""
    argv = sys.argv[1:] if arguments is None else arguments
    try:
        run(parse(RouterConfig, argv, program="w2c router", table="router"), stop_on_signals())
    except (ConfigError, ConnectionFailedError) as error:
        return fail(error, "w2c router")
    return 0
