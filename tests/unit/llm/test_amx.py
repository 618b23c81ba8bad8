"""llama.cpp built for AMX, whose products end the process: none is made."""

from pathlib import Path
from typing import Any

import llama_cpp
import pytest

from w2c.errors import ConfigError
from w2c_llm.bench.trial import PlainModel
from w2c_llm.llama_model import LlamaModel


def says(monkeypatch: pytest.MonkeyPatch, *features: bytes) -> None:
    line = b"CPU : " + b"".join(feature + b" = 1 | " for feature in features)
    monkeypatch.setattr(llama_cpp, "llama_print_system_info", lambda: line)


@pytest.mark.parametrize(
    ("features", "extra_buffers"), [((b"AVX512", b"AMX_INT8"), False), ((b"AVX512",), True)]
)
def test_a_model_is_loaded_into_buffers_that_are_safe_to_multiply(
    tiny_model: Path,
    monkeypatch: pytest.MonkeyPatch,
    features: tuple[bytes, ...],
    extra_buffers: bool,
) -> None:
    says(monkeypatch, *features)
    load = llama_cpp.llama_model_load_from_file
    asked: list[bool] = []

    def load_noting(path: bytes, parameters: Any) -> Any:
        asked.append(bool(parameters.use_extra_bufts))
        return load(path, parameters)

    monkeypatch.setattr(llama_cpp, "llama_model_load_from_file", load_noting)
    LlamaModel(tiny_model).close()
    assert asked == [extra_buffers]


def test_the_bench_does_not_run_into_it(tiny_model: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    says(monkeypatch, b"AMX_INT8")
    with pytest.raises(ConfigError, match="built for AMX"):
        PlainModel(tiny_model, threads=1)
