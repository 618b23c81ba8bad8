"""The access list says what the registry says, and nothing more."""

import json
from itertools import product
from pathlib import Path
from typing import Any

import pytest
import zenoh

from support.deploy import ROOT, load_access_control
from w2c import topics
from w2c.bus.zenoh_config import base_config

access_control = load_access_control()
ROBOT = "talos"
MODEL_SERVICES = ("llm", "grounding")


def may(subject: str, message: str, flow: str, key: str) -> bool:
    """Tell whether the generated list lets a message pass."""
    section: dict[str, Any] = access_control.access_control(ROBOT, trust_local=False)
    wanted = {
        rule
        for policy in section["policies"]
        if subject in policy["subjects"]
        for rule in policy["rules"]
    }
    return any(
        zenoh.KeyExpr(expression).includes(zenoh.KeyExpr(key))
        for rule in section["rules"]
        if rule["id"] in wanted and message in rule["messages"] and flow in rule["flows"]
        for expression in rule["key_exprs"]
    )


@pytest.mark.parametrize("subject", list(access_control.subjects()))
def test_nobody_writes_a_key_that_is_not_his(subject: str) -> None:
    processes = access_control.subjects()[subject]
    for topic, writer in product(topics.TOPICS, (*topics.SERVICES, "launcher")):
        if topic.service not in ("*", writer):
            continue
        allowed = may(subject, "put", "ingress", topic.key(ROBOT, writer))
        assert allowed == (writer in processes), topic.key(ROBOT, writer)


def test_only_the_robot_host_sends_joint_commands() -> None:
    key = topics.JOINT_COMMAND.key(ROBOT)
    senders = [name for name in access_control.subjects() if may(name, "put", "ingress", key)]

    assert senders == ["robot"]


def test_truth_reaches_the_robot_host_evaluation_and_recorder_only() -> None:
    key = topics.TRUTH.key(ROBOT)
    for message, flow in (("put", "egress"), ("declare_subscriber", "ingress")):
        readers = [name for name in access_control.subjects() if may(name, message, flow, key)]
        assert sorted(readers) == ["evaluation", "recorder", "robot"]


def test_the_recorder_may_subscribe_to_everything_of_its_robot() -> None:
    assert may("recorder", "declare_subscriber", "ingress", f"w2c/v1/{ROBOT}/**")
    assert not may("recorder", "declare_subscriber", "ingress", "w2c/v1/other/**")


@pytest.mark.parametrize("service", MODEL_SERVICES)
def test_model_services_move_nothing(service: str) -> None:
    for method in (topics.PLACE, topics.RELEASE, topics.SAY, topics.CONFIRM):
        assert not may(service, "query", "ingress", method.key(ROBOT, "0"))


@pytest.mark.parametrize("subject", list(access_control.subjects()))
def test_everyone_may_stop_the_robot(subject: str) -> None:
    assert may(subject, "query", "ingress", topics.ROBOT_STOP.key(ROBOT, "0"))


@pytest.mark.parametrize("subject", list(access_control.subjects()))
def test_calls_and_services_are_those_of_the_registry(subject: str) -> None:
    processes = access_control.subjects()[subject]
    for method in topics.METHODS:
        key = method.key(ROBOT, "0")
        callers = method.callers
        expected = "*" in callers or any(process in callers for process in processes)
        assert may(subject, "query", "ingress", key) == expected, key
        assert may(subject, "declare_queryable", "ingress", key) == (method.service in processes)


def test_a_liveliness_token_is_ones_own() -> None:
    assert may("llm", "liveliness_token", "ingress", topics.liveliness_key(ROBOT, "llm", "0"))
    assert not may("llm", "liveliness_token", "ingress", topics.liveliness_key(ROBOT, "robot", "0"))


def test_every_process_of_the_registry_has_a_subject() -> None:
    spoken_for = {name for names in access_control.subjects().values() for name in names}

    assert set(topics.SERVICES) <= spoken_for
    assert {topic.service for topic in topics.TOPICS} - {"*"} <= spoken_for
    named = {reader for topic in topics.TOPICS for reader in topic.readers}
    named |= {caller for method in topics.METHODS for caller in method.callers}
    assert named - {"*"} <= spoken_for


def test_the_base_router_shares_the_settings_of_every_session() -> None:
    """Different leases on the two ends of a link lose it for good (eclipse-zenoh/zenoh#2806)."""
    shared = base_config("router")
    base = zenoh.Config.from_file(str(ROOT / "deploy" / "zenoh-router.json5"))
    for path in (
        "mode",
        "scouting/multicast/enabled",
        "scouting/gossip/enabled",
        "transport/shared_memory/enabled",
        "transport/link/tx/lease",
        "transport/link/tx/keep_alive",
    ):
        assert base.get_json(path) == shared.get_json(path), path


@pytest.mark.parametrize("trust_local", [False, True])
def test_the_written_file_is_a_router_configuration(tmp_path: Path, *, trust_local: bool) -> None:
    path = tmp_path / "router.json5"
    flags = ["--trust-local"] if trust_local else []
    arguments = ["--robot", ROBOT, "--certificates", "/certs", "--output", str(path)]
    assert access_control.main([*arguments, *flags]) == 0

    config = zenoh.Config.from_file(str(path))
    endpoints = json.loads(config.get_json("listen/endpoints"))
    assert json.loads(config.get_json("access_control/default_permission")) == "deny"
    assert [e.split("/")[0] for e in endpoints] == (["tcp", "tls"] if trust_local else ["tls"])
    assert all("enable_mtls=true" in e for e in endpoints if e.startswith("tls"))
