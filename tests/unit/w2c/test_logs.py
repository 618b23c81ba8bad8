"""What is logged is on the bus, too."""

import json
import logging
from pathlib import Path

import pytest

from w2c import topics
from w2c.bus import InProcessHub
from w2c.errors import ConfigError
from w2c.logs import configure_logs, logs_on


def test_the_log_is_published_with_its_fields_while_the_block_runs() -> None:
    hub = InProcessHub()
    bus, recorder = hub.connect("llm"), hub.connect("recorder")
    queue = recorder.queue(topics.LOG)
    log = logging.getLogger("w2c.test")
    with logs_on(bus):
        log.warning("target %s refused", "t-1", extra={"reason": "stale"})
    log.warning("not published any more")
    received = queue.receive(1.0)
    assert received is not None
    assert (received.message.level, received.message.text) == ("warning", "target t-1 refused")
    assert received.message.fields == {"reason": "stale"}
    assert queue.receive(0.0) is None


def test_the_file_has_a_json_object_a_line(tmp_path: Path) -> None:
    configure_logs("llm", "info", str(tmp_path))
    logging.getLogger("w2c.test").info("ready", extra={"seconds": 1.5})
    logging.getLogger().handlers[-1].close()
    logging.getLogger().handlers.clear()
    entry = json.loads((tmp_path / "llm.jsonl").read_text().splitlines()[-1])
    assert (entry["text"], entry["seconds"]) == ("ready", "1.5")


def test_an_unknown_level_names_the_known_ones() -> None:
    with pytest.raises(ConfigError, match="debug, info, warning, error"):
        configure_logs("llm", "loud", "")
