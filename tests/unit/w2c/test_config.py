"""Configuration: TOML file < flags, and clear words about what is wrong."""

from pathlib import Path

import pytest

from w2c.config import ServiceConfig, parse
from w2c.errors import ConfigError, MissingExtraError
from w2c.extras import needs_extra


class Example(ServiceConfig, frozen=True, kw_only=True):
    """An example."""

    threads: int = 2
    """How many."""


def test_flags_override_the_file_and_the_file_the_defaults(tmp_path: Path) -> None:
    file = tmp_path / "c.toml"
    file.write_text('[llm]\nrobot = "talos"\nthreads = 4\ninstance = "b"\n')
    config = parse(
        Example, ["--config", str(file), "--threads", "8"], program="w2c llm", table="llm"
    )
    assert (config.robot, config.threads, config.instance) == ("talos", 8, "b")


def test_the_robot_has_no_default() -> None:
    with pytest.raises(SystemExit) as exit_:
        parse(Example, [], program="w2c llm")
    assert exit_.value.code == 2


def test_a_robot_id_that_breaks_keys_is_refused() -> None:
    with pytest.raises(ConfigError, match="robot"):
        parse(Example, ["--robot", "a/b"], program="w2c llm")


def test_an_unknown_field_of_the_file_names_the_known_ones(tmp_path: Path) -> None:
    file = tmp_path / "c.toml"
    file.write_text('[llm]\nrobot = "talos"\nthreds = 4\n')
    with pytest.raises(ConfigError, match=r"threds.*threads"):
        parse(Example, ["--config", str(file)], program="w2c llm", table="llm")


def test_a_broken_file_says_where(tmp_path: Path) -> None:
    file = tmp_path / "c.toml"
    file.write_text("[llm\n")
    with pytest.raises(ConfigError, match="line 1"):
        parse(Example, ["--config", str(file)], program="w2c llm", table="llm")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"nowhere\.toml"):
        parse(Example, ["--config", str(tmp_path / "nowhere.toml")], program="w2c llm")


def test_an_unknown_flag_is_wrong_usage() -> None:
    with pytest.raises(SystemExit) as exit_:
        parse(Example, ["--robot", "talos", "--fast"], program="w2c llm")
    assert exit_.value.code == 2


def test_a_missing_dependency_names_the_command_that_installs_it() -> None:
    with pytest.raises(MissingExtraError, match=r"\[llm\]"), needs_extra("llm"):
        raise ModuleNotFoundError("No module named 'llama_cpp'", name="llama_cpp")


def test_a_missing_module_of_our_own_is_a_bug_not_an_extra() -> None:
    with pytest.raises(ModuleNotFoundError), needs_extra("llm"):
        raise ModuleNotFoundError("No module named 'w2c_llm.x'", name="w2c_llm.x")
