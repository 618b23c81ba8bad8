"""Busy ports and full or unwritable places are clear errors, before anything starts."""

import socket
from pathlib import Path

import pytest

from w2c.errors import ConfigError
from w2c_launcher import run_directory
from w2c_launcher.ports import free_port, require_free


def test_a_busy_port_is_named_with_the_flag_that_changes_it() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        with pytest.raises(ConfigError, match=rf"port {port} is in use.*--console-port"):
            require_free(f"tcp/127.0.0.1:{port}", "--console-port")


def test_a_free_port_passes() -> None:
    require_free(f"tcp/127.0.0.1:{free_port()}", "--router")


def test_an_endpoint_without_a_port_is_refused() -> None:
    with pytest.raises(ConfigError, match="tcp/HOST:PORT"):
        require_free("tcp/localhost", "--router")


def test_a_place_that_is_no_directory_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="--run-directory"):
        run_directory.make_run_directory(str(tmp_path / "file" / "run"))


def test_a_full_disk_is_refused_before_anything_starts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_directory, "LEAST_FREE_BYTES", 10**18)
    with pytest.raises(ConfigError, match="make room"):
        run_directory.make_run_directory(str(tmp_path / "run"))
