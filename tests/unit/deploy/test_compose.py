"""compose.yaml is valid, complete, starts verbs that exist, and exposes nothing by accident."""

import json
from collections.abc import Callable
from importlib.metadata import entry_points
from importlib.resources import files
from typing import Any

import jsonschema
import pytest
import yaml

from support.deploy import ROOT, dot_env, load_yaml, read_compose
from w2c import realtime, router, service, topics
from w2c.config import parse
from w2c_launcher.profiles import Options, processes

COMPOSE = ROOT / "compose.yaml"
HOSTS = ROOT / "deploy" / "hosts"
VARIABLES = {
    "W2C_ROUTER": "robot-host.local",
    "W2C_CERTIFICATES": "/etc/w2c",
    "W2C_ADDRESS": "192.0.2.10",
}
ON_GPU = "-gpu"

Service = dict[str, Any]


@pytest.fixture(scope="module")
def services() -> dict[str, Service]:
    found: dict[str, Service] = read_compose(COMPOSE)["services"]
    return found


@pytest.fixture(scope="module")
def specification() -> jsonschema.Draft202012Validator:
    """The schema of the compose specification, as the package check-jsonschema carries it."""
    path = files("check_jsonschema") / "builtin_schemas" / "vendor" / "compose-spec.json"
    return jsonschema.Draft202012Validator(json.loads(path.read_text()))


def overrides() -> list[str]:
    return sorted(path.name for path in HOSTS.glob("*.yaml"))


def test_compose_fits_the_specification(
    specification: jsonschema.Draft202012Validator,
) -> None:
    specification.validate(load_yaml(COMPOSE.read_text()))


@pytest.mark.parametrize("name", overrides())
def test_overrides_fit_the_specification(
    specification: jsonschema.Draft202012Validator, name: str
) -> None:
    specification.validate(read_compose(HOSTS / name, VARIABLES))


@pytest.mark.parametrize(
    "change",
    [
        {"comand": ["router"]},
        {"ports": 8080},
        {"restart": 3},
        {"healthcheck": {"test": ["CMD", "true"], "intervall": "3s"}},
        {"depends_on": {"router": {"condition": "service_happy"}}},
    ],
)
def test_the_specification_refuses_mistakes(
    specification: jsonschema.Draft202012Validator, change: Service
) -> None:
    document = read_compose(COMPOSE)
    document["services"]["recorder"] |= change

    assert not specification.is_valid(document)


def test_every_process_of_the_system_is_a_service_and_nothing_else_is(
    services: dict[str, Service],
) -> None:
    plain = {name for name in services if not name.endswith(ON_GPU)}

    assert plain == {*topics.SERVICES, "router"}


def test_the_gpu_profile_has_the_model_services_on_a_card(services: dict[str, Service]) -> None:
    on_gpu = {name: row for name, row in services.items() if name.endswith(ON_GPU)}

    assert set(on_gpu) == {"llm-gpu", "grounding-gpu"}
    for name, row in on_gpu.items():
        plain = services[name.removesuffix(ON_GPU)]
        (device,) = row["deploy"]["resources"]["reservations"]["devices"]
        assert (device["driver"], device["capabilities"]) == ("nvidia", ["gpu"])
        assert (row["profiles"], plain["profiles"]) == (["gpu"], ["cpu"])
        assert row["command"][: len(plain["command"])] == plain["command"]
        different = {key for key in row if row[key] != plain.get(key)}
        assert different == {"profiles", "image", "build", "command", "deploy"}


def test_without_a_choice_the_models_run_on_the_processor() -> None:
    assert dot_env()["COMPOSE_PROFILES"] == "cpu"


class _Parsed(Exception):  # noqa: N818 - no error: it carries what was parsed out of main()
    def __init__(self, config: Any) -> None:
        self.config = config


def parse_command(monkeypatch: pytest.MonkeyPatch, command: list[str]) -> Any:
    """Return the configuration that a verb makes of its flags, instead of running it."""

    def parse_only(name: str, config_type: Any, _load: Any, arguments: Any, **_: Any) -> int:
        assert name == command[0]
        raise _Parsed(parse(config_type, arguments, program=name, table=name))

    def take(config: Any, _stop: Any) -> None:
        raise _Parsed(config)

    monkeypatch.setattr(service, "main", parse_only)
    monkeypatch.setattr(router, "run", take)
    (point,) = entry_points(group="w2c.commands", name=command[0])
    verb: Callable[[list[str]], int] = point.load()
    with pytest.raises(_Parsed) as parsed:
        verb(command[1:])
    return parsed.value.config


COMMANDS = {
    f"{file}:{name}": row["command"]
    for file, document in {
        "compose.yaml": read_compose(COMPOSE),
        **{name: read_compose(HOSTS / name, VARIABLES) for name in overrides()},
    }.items()
    for name, row in document["services"].items()
    if "command" in row
}


@pytest.mark.parametrize("where", list(COMMANDS))
def test_every_command_is_a_verb_whose_flags_parse(
    monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    config = parse_command(monkeypatch, COMMANDS[where])

    name = where.split(":")[1].removesuffix(ON_GPU)
    assert COMMANDS[where][0] == name
    if name != "router":
        assert config.robot == "talos"
        assert config.run_directory.startswith("/runs/")


@pytest.mark.parametrize("name", topics.SERVICES)
def test_health_is_asked_of_the_service_itself(services: dict[str, Service], name: str) -> None:
    from w2c_launcher.commands import StatusConfig

    program, verb, *flags = services[name]["healthcheck"]["test"][1:]
    config = parse(StatusConfig, flags, program="w2c status")

    assert (program, verb) == ("w2c", "status")
    assert config.wait_for == (name,)
    assert config.router == "tcp/router:7447"


def test_robot_and_those_on_its_host_meet_at_its_own_endpoint(
    monkeypatch: pytest.MonkeyPatch, services: dict[str, Service]
) -> None:
    endpoints = {
        name: parse_command(monkeypatch, services[name]["command"]).robot_endpoint
        for name in ("robot", "camera", "controller", "console")
    }

    assert endpoints.pop("robot") == "tcp/0.0.0.0:7448"
    assert set(endpoints.values()) == {"tcp/robot:7448"}


def test_robot_and_camera_see_the_same_scene_and_the_image_has_it(
    monkeypatch: pytest.MonkeyPatch, services: dict[str, Service]
) -> None:
    robot, camera = (
        parse_command(monkeypatch, services[name]["command"]).scene for name in ("robot", "camera")
    )

    assert robot == camera
    assert f"--out {robot}" in (ROOT / "deploy" / "Dockerfile").read_text()


def test_only_the_page_is_published_and_only_to_this_machine(
    services: dict[str, Service],
) -> None:
    published = {name: row["ports"] for name, row in services.items() if "ports" in row}

    assert published == {"console": ["127.0.0.1:8080:8080"]}
    assert read_compose(COMPOSE)["networks"]["bus"]["internal"] is True
    with_a_way_out = [name for name, row in services.items() if row["networks"] != ["bus"]]
    assert with_a_way_out == ["console"]


def test_a_key_that_stands_twice_is_refused_as_compose_does() -> None:
    with pytest.raises(yaml.YAMLError, match="'ulimits' stands twice"):
        load_yaml("x: &x {ulimits: {rtprio: 50}}\na: {<<: *x, ulimits: 1, cpus: 2, ulimits: 2}")

    assert load_yaml("x: &x {cpus: 1}\na: {<<: *x, cpus: 2}")["a"] == {"cpus": 2}


def test_only_the_loops_may_raise_their_priority_and_nobody_is_privileged(
    services: dict[str, Service],
) -> None:
    limits = {name: row["ulimits"] for name, row in services.items() if "ulimits" in row}

    assert limits.keys() == {"robot", "controller"}
    for one in limits.values():
        assert one["rtprio"] > max(realtime.CONTROLLER_PRIORITY, realtime.ROBOT_PRIORITY)
        assert one["memlock"] == -1
    for name, row in services.items():
        assert row["cap_drop"] == ["ALL"], name
        assert not row.get("privileged", False), name
        assert "cap_add" not in row, name


def test_what_waits_for_the_loops_is_what_the_launcher_makes_nice(
    services: dict[str, Service],
) -> None:
    specs = processes("simulation", Options("talos", "tcp/x:1", "tcp/x:2", "/runs", 8080))
    nice = {spec.name for spec in specs if spec.niceness}

    waits = {name.removesuffix(ON_GPU) for name, row in services.items() if "cpu_shares" in row}

    assert waits == nice


def test_the_hosts_share_out_all_services_without_overlap(services: dict[str, Service]) -> None:
    def runs(file: str, profile: str) -> set[str]:
        """Apply compose's rule: lists of profiles add up; without one a service always runs."""
        changes = read_compose(HOSTS / file, VARIABLES)["services"]
        assert set(changes) <= set(services)
        profiles = {
            name: [*row.get("profiles", []), *changes.get(name, {}).get("profiles", [])]
            for name, row in services.items()
        }
        return {name for name, wanted in profiles.items() if not wanted or profile in wanted}

    on_gpu_host = runs("gpu-host.yaml", "gpu")
    on_robot_host = runs("robot-host.yaml", "robot")

    assert on_gpu_host == {"llm-gpu", "grounding-gpu"}
    assert on_robot_host == {*topics.SERVICES, "router"} - {"llm", "grounding"}


def test_the_model_services_show_their_own_certificate() -> None:
    for name in ("llm", "grounding"):
        command = COMMANDS[f"gpu-host.yaml:{name}{ON_GPU}"]
        endpoint = command[command.index("--router") + 1]
        address, _, settings = endpoint.partition("#")

        assert address == "tls/robot-host.local:7449"
        assert dict(pair.split("=") for pair in settings.split(";")) == {
            "root_ca_certificate_file": "/certs/ca.pem",
            "connect_certificate_file": f"/certs/{name}.pem",
            "connect_private_key_file": f"/certs/{name}.key",
            "enable_mtls": "true",
        }
