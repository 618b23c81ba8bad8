"""Compiled code belongs to one state of the sources."""

import os
from pathlib import Path
from typing import Any

import pytest

from w2c_controller import compiled


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package with a compiled function, one that calls it, and a module without any."""
    package = tmp_path / "package"
    (package / "inner").mkdir(parents=True)
    (package / "inner" / "callee.py").write_text("@compiled\ndef half(x): return x / 2\n")
    (package / "caller.py").write_text("@compiled\ndef quarter(x): return half(half(x))\n")
    (package / "node.py").write_text("print('on the bus')\n")
    return package


def test_a_change_of_any_compiled_function_is_another_state(package: Path) -> None:
    before = compiled.source_digest(package)
    assert compiled.source_digest(package) == before
    callee = package / "inner" / "callee.py"
    callee.write_text(callee.read_text().replace("/ 2", "/ 3"))
    assert compiled.source_digest(package) != before


def test_what_is_not_compiled_does_not_count(package: Path) -> None:
    before = compiled.source_digest(package)
    (package / "node.py").write_text("print('elsewhere')\n")
    assert compiled.source_digest(package) == before


def test_a_moved_function_is_another_state(package: Path) -> None:
    before = compiled.source_digest(package)
    (package / "inner" / "callee.py").rename(package / "callee.py")
    assert compiled.source_digest(package) != before


def test_the_code_of_other_states_is_removed(tmp_path: Path) -> None:
    for name in ("compiled-old", "compiled-new", "other"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "code.nbc").write_bytes(b"\0")
    assert compiled.remove_old(tmp_path / "compiled-new") == [tmp_path / "compiled-old"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["compiled-new", "other"]


def test_a_package_that_cannot_be_written_has_its_code_in_the_users_cache(
    package: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    assert compiled.cache_root(package) == package / "__pycache__"
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert compiled.cache_root(package) == tmp_path / "words2contact"


def test_functions_are_kept_there_also_after_numba_read_its_settings_anew(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    config = pytest.importorskip("numba").config
    if "NUMBA_CACHE_DIR" in os.environ:
        pytest.skip("NUMBA_CACHE_DIR says where compiled code is kept")
    package = Path(compiled.__file__).parent
    name = f"{compiled.PREFIX}{compiled.source_digest(package)}"
    monkeypatch.setattr(config, "CACHE_DIR", "")

    def half(number: float) -> float:
        return number / 2

    function: Any = compiled.compiled(half)
    kept = Path(function.stats.cache_path)
    assert kept.is_relative_to(compiled.cache_root(package) / name)
