"""Where the page may be served."""

import socket

import pytest

from fakes.console_world import ConsoleWorld
from w2c.clock import RealClock
from w2c.config import load
from w2c.errors import ConfigError
from w2c_console.config import ConsoleConfig, check_exposure
from w2c_console.node import ConsoleNode
from w2c_console.server import bind


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "::1", "127.0.0.7"])
def test_this_machine_needs_no_permission(host: str) -> None:
    check_exposure(ConsoleConfig(robot="talos", host=host))


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.4", "robot.example.org"])  # noqa: S104
def test_other_machines_need_the_flag(host: str) -> None:
    with pytest.raises(ConfigError, match="--allow-remote"):
        check_exposure(ConsoleConfig(robot="talos", host=host))
    check_exposure(ConsoleConfig(robot="talos", host=host, allow_remote=True))


def test_a_port_in_use_is_named_with_the_flag_that_changes_it() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        world = ConsoleWorld()
        node = ConsoleNode(ConsoleConfig(robot="test", port=port), world.console, RealClock())
        with pytest.raises(ConfigError, match=rf"port {port} .*--port"):
            node.configure()
        node.close()
        world.close()


def test_an_address_of_another_machine_is_an_error_of_the_flag() -> None:
    with pytest.raises(ConfigError, match=r"192\.0\.2\.1"):
        bind("192.0.2.1", 0)


def test_a_port_out_of_range_is_refused() -> None:
    with pytest.raises(ConfigError, match="port"):
        load(ConsoleConfig, {"robot": "talos", "port": 70_000})
