"""What is said when a checkpoint cannot be loaded, and what is remembered of phrases."""

import errno
from typing import Any

import httpx
import pytest
from huggingface_hub import errors as hub
from huggingface_hub.utils import are_progress_bars_disabled  # type: ignore[attr-defined]

from w2c.errors import ModelError
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.pretrained import Remembered, load_processor

NAME = "owner/model"


def failing(cause: Exception) -> Any:
    """Return a class whose `from_pretrained` fails as transformers does: its own error, a cause."""

    class Processor:
        @staticmethod
        def from_pretrained(source: str, **_: Any) -> None:
            raise OSError(f"Can't load it for '{source}'.\nA long explanation.") from cause

    return Processor


def answered(kind: type[hub.HfHubHTTPError], status: int) -> hub.HfHubHTTPError:
    request = httpx.Request("GET", "https://huggingface.co/owner/model")
    # Any: the hub carries a copy of httpx under another name, with the same classes.
    response: Any = httpx.Response(status, request=request)
    return kind("no", response=response)


CASES = [
    (answered(hub.GatedRepoError, 403), "accept the terms at https://huggingface.co/owner/model"),
    (answered(hub.RevisionNotFoundError, 404), "no such --revision"),
    (answered(hub.RepositoryNotFoundError, 404), "no such model, or it is private"),
    (answered(hub.HfHubHTTPError, 503), "did not answer.*hf download owner/model"),
    (hub.LocalEntryNotFoundError("not in the cache"), "did not answer.*give --model DIR"),
    (ConnectionError("unreachable"), "did not answer"),
    (ValueError("not weights"), "damaged or of another architecture"),
    (OSError(errno.ENOSPC, "No space left on device"), "disk is full: free some space"),
    (MemoryError(), "Memory is full: .*--dtype bfloat16"),
]


@pytest.mark.parametrize(("cause", "advice"), CASES, ids=[type(case[0]).__name__ for case in CASES])
def test_each_reason_has_its_next_step(cause: Exception, advice: str) -> None:
    config = ModelConfig(model=NAME, allow_download=True)
    with pytest.raises(ModelError, match=f"'owner/model' cannot be loaded: Can't load.*{advice}"):
        load_processor(failing(cause), config, NAME)


def test_what_may_not_be_fetched_is_told_how_to_fetch_it() -> None:
    cause = hub.LocalEntryNotFoundError("not in the cache")
    with pytest.raises(ModelError, match=r"not wholly, on this machine.*--allow-download"):
        load_processor(failing(cause), ModelConfig(model=NAME), NAME)


class Noting:
    """Keeps what it was asked with."""

    asked: dict[str, Any] = {}

    @classmethod
    def from_pretrained(cls, source: str, **arguments: Any) -> str:
        cls.asked = {"source": source, "quiet": are_progress_bars_disabled(), **arguments}
        return "loaded"


def test_only_a_download_shows_progress_and_only_leave_to_download_asks_the_hub() -> None:
    assert load_processor(Noting, ModelConfig(revision="abc"), NAME, backend="pil") == "loaded"
    expected = {"source": NAME, "local_files_only": True, "revision": "abc", "backend": "pil"}
    assert Noting.asked == {**expected, "quiet": True}
    load_processor(Noting, ModelConfig(allow_download=True), NAME)
    assert Noting.asked == {"source": NAME, "local_files_only": False, "quiet": False}
    load_processor(Noting, ModelConfig(), NAME)
    assert Noting.asked["quiet"]


def test_the_latest_phrases_are_remembered_and_no_more() -> None:
    computed: list[str] = []

    def length(phrase: str) -> int:
        computed.append(phrase)
        return len(phrase)

    remembered = Remembered[int](limit=2)
    assert [remembered.get(phrase, length) for phrase in ("a", "bb", "a", "ccc")] == [1, 2, 1, 3]
    assert computed == ["a", "bb", "ccc"]
    assert remembered.get("a", length) == 1
    assert computed == ["a", "bb", "ccc"]
    assert remembered.get("bb", length) == 2
    assert computed == ["a", "bb", "ccc", "bb"]
